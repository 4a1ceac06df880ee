// All lights of a snapshot: chooses which to sample (light_choice.h), and answers for rays that hit one.
//
// Constant domes take no part in the choice of a light. BSDF sampling finds them with less noise than next-event
// estimation, and where next-event estimation samples them, each is sampled with probability 1.
#pragma once

#include <algorithm>
#include <array>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/light/light.h"
#include "core/light/light_choice.h"
#include "core/light/light_tree.h"

namespace alabaster {

/// Tells if next-event estimation samples constant domes. BSDF sampling alone has less noise and needs no shadow ray,
/// except on surfaces that scatter, where the local lobes are picked too rarely.
enum class ConstantDomes { sampled, bsdf_sampling_only };

/// How lights are sampled at a point. The pdf of a light that a ray from there intersects is computed with the
/// same search.
struct LightSampleContext {
  LightSampleContext(ConstantDomes how = ConstantDomes::sampled, const Vec3f& lobe = Vec3f(0, 0, 0), float when = 0)
      : domes(how), n(lobe), time(when) {}
  ConstantDomes domes;
  Vec3f n;     // unit: a lobe weighs light by the cosine to it; zero: none does
  float time;  // of the shutter, at which light is sampled; a ray has its own
};

/// Unit normals of two planes through a point: of its surface and of its lobe. A light that lies wholly below either
/// gives nothing there.
using Horizon = std::array<Vec3f, 2>;

/// The shares of the f that a ray's direction was sampled with.
struct LobeShares {
  Rgb diffuse{1.0f}, specular{0.0f};
};

class LightSet {
 public:
  LightSet() = default;
  /// Beside each light, by its index.
  struct Traits {
    std::vector<bool> visible_to_camera = {};  // lights beyond its end are visible
    std::vector<uint32_t> shadow_links = {};   // of LightParameters; lights beyond its end have none
    std::vector<LobeScales> scales = {};       // lights beyond its end have scales of 1
    std::vector<uint32_t> groups = {};         // of LightParameters; lights beyond its end have none
  };
  /// Up to `sample_all_up_to` lights: one sample of each per point. Samples that face away mostly cost no ray, and no
  /// light adds to another's noise. Above that, one light per point, picked by importance, or by a tree above
  /// kMostWeighed, and one sample of each constant dome.
  LightSet(std::vector<Light> lights, Traits traits, size_t sample_all_up_to = 0);

  size_t size() const { return lights_.size(); }

  /// The number of lights to sample at a point.
  size_t draws(const LightSampleContext& at) const {
    if (sample_all_) return lights_.size();
    return 1 + (at.domes == ConstantDomes::sampled ? constant_domes_.size() : 0);
  }
  /// A direction of the k-th of them, k < draws(at). The pdf includes the choice. Empty: no light arrives. A set that
  /// samples all leaves out lights below the horizon. u: the choice, then the direction.
  std::optional<LightSample> draw(size_t k, const Vec3f& p, const Horizon& horizon, const std::array<float, 4>& u,
                                  const LightSampleContext& at) const {
    if (sample_all_) {
      if (is_left_out(at.domes, k) || is_below(k, p, horizon)) return std::nullopt;
      return sample_light(k, p, shifted({u[1], u[2]}, k), at.n, at.time);
    }
    return k == 0 ? sample(p, u[0], {u[1], u[2]}, at.n, at.time)
                  : sample_light(constant_domes_[k - 1], p, dome_numbers(k - 1, u), at.n, at.time);
  }

  /// One direction of one chosen light, never of a constant dome. The pdf includes the choice of light, for a delta
  /// light too. Empty: no light arrives.
  std::optional<LightSample> sample(const Vec3f& p, float u_light, const Vec2f& u, const Vec3f& n = Vec3f(0, 0, 0),
                                    float time = 0) const;

  /// Calls take(light's index, Rgb) with what each light without geometry emits along the ray: finite ones from tmin to
  /// ray.tmax and, if the ray `escaped` from the scene, infinite ones (distant, dome). Lights do not block rays: all
  /// are taken, each weighed by `weigh(pdf)` or `weigh(pdf, distance)`, the pdf that draw(., ray.org, ., u, search) has
  /// for this direction of this light, with the choice in it. Lights with a shadow link are left out, but of camera
  /// rays. `shares`: of the lobes that send the light on; null: it is seen as it is.
  template <class Weigh, class Take>
  void each_emitted(const Ray& ray, bool escaped, bool camera_ray, const LightSampleContext& search, const Weigh& weigh,
                    float tmin, const LobeShares* shares, const Take& take) const {
    const auto weight = [&](float pdf, float distance) {
      if constexpr (std::is_invocable_v<const Weigh&, float, float>)
        return weigh(pdf, distance);
      else
        return weigh(pdf);
    };
    const auto add = [&](size_t i) {
      if (camera_ray && !visible_to_camera_[i]) return;
      const auto hit = intersect(i, ray, search.n);
      if (!hit || hit->t < tmin || (hit->t > ray.tmax && !is_infinite(i))) return;  // clipping cuts no sky off
      take(i, sent_on(i, hit->radiance, shares) * weight(pdf_of(i, *hit, ray.org, search.domes), hit->t));
    };
    if (tree_.empty())
      for (const uint32_t i : finite_) add(i);
    else
      tree_.intersect(ray, [&](size_t i) {
        if (shadow_links_.empty() || shadow_links_[i] == 0) add(i);
      });
    if (escaped)
      for (const uint32_t i : infinite_) add(i);
    if (camera_ray)
      for (const uint32_t i : shadow_linked_)
        if (escaped || !is_infinite(i)) add(i);
  }

  /// The random numbers with which sample_cosine_hemisphere, about the lobe, gives the direction of the first constant
  /// dome that draw(., p, ., u, ...) gives. Empty: there is none, or all other lights together give more at p,
  /// unoccluded. That depends on p alone.
  std::optional<Vec2f> leading_dome_numbers(const Vec3f& p, const std::array<float, 4>& u) const;

  /// The group of light i; 0: none.
  uint32_t group_of(size_t i) const { return groups_.empty() ? 0 : groups_[i]; }

  bool has_shadow_links() const { return !shadow_linked_.empty(); }
  /// The same for a ray that is no camera ray, of the lights with a shadow link. No surface stops them here:
  /// Rgb `arrives(shadow_link, distance)` is the share of the light that does.
  template <class Weigh, class Arrives, class Take>
  void each_emitted_with_links(const Ray& ray, const LightSampleContext& search, const Weigh& weigh,
                               const Arrives& arrives, const LobeShares* shares, const Take& take) const {
    for (const uint32_t i : shadow_linked_) {
      const auto hit = intersect(i, ray, search.n);
      if (!hit) continue;
      const Rgb share = arrives(shadow_links_[i], hit->t);
      if (!is_black(share))
        take(i, sent_on(i, hit->radiance, shares) * share * weigh(pdf_of(i, *hit, ray.org, search.domes)));
    }
  }

  /// pdf (with the choice in it) that draw(., ray.org, ...) has for the point of an emissive triangle that the
  /// ray of unit direction hit at distance t; 0 if it is no light.
  float mesh_light_pdf(const Ray& ray, float t, uint32_t instance, uint32_t triangle) const;

  const std::vector<Light>& lights() const { return lights_; }
  /// On the heap, without textures, which others may share.
  size_t memory_bytes() const;
  /// Probability that sample(p, ...) chooses light i, which is no constant dome.
  float choice_probability(size_t i, const Vec3f& p) const {
    return tree_.empty() ? LightChoice(lights_, scales_, p).probability(i) : tree_.probability(lights_, p, i);
  }

 private:
  std::optional<LightHit> intersect(size_t i, const Ray& ray, const Vec3f& n) const;
  Rgb sent_on(size_t i, const Rgb& radiance, const LobeShares* shares) const {
    if (scales_.empty() || !shares) [[likely]]
      return radiance;
    return radiance * (shares->diffuse * scales_[i].diffuse + shares->specular * scales_[i].specular);
  }
  std::optional<LightSample> sample_light(size_t i, const Vec3f& p, const Vec2f& u, const Vec3f& n, float time) const;
  /// Another point of the unit square for each light, as well spread as u: shifted by Roberts' R2 lattice.
  static Vec2f shifted(const Vec2f& u, size_t i) {
    if (i == 0) return u;
    // Truncation, for std::floor is a call: x >= 0.
    const auto wrap = [](float x) {
      return std::min(x - static_cast<float>(static_cast<int64_t>(x)), kOneMinusEpsilon);
    };
    const auto n = static_cast<float>(i);
    return {wrap(u.x + n * 0.7548776662f), wrap(u.y + n * 0.5698402910f)};
  }
  /// The random numbers of constant dome k (of constant_domes_) where one light is chosen of many.
  static Vec2f dome_numbers(size_t k, const std::array<float, 4>& u) { return shifted({u[1], u[2]}, k + 1); }
  bool is_below(size_t i, const Vec3f& p, const Horizon& horizon) const;
  bool is_infinite(size_t i) const {
    if (const auto* moving = std::get_if<MovingLight>(&lights_[i])) [[unlikely]]
      return !moving->extent().finite;
    return std::holds_alternative<DistantLight>(lights_[i]) || std::holds_alternative<DomeLight>(lights_[i]);
  }
  /// The pdf that draw(., p, ...) has for a light i that a ray has met.
  float pdf_of(size_t i, const LightHit& hit, const Vec3f& p, ConstantDomes domes) const {
    if (is_left_out(domes, i)) return 0;
    if (sample_all_ || is_constant_dome(lights_[i])) return hit.pdf;
    return hit.pdf * choice_probability(i, p);
  }
  bool is_left_out(ConstantDomes domes, size_t i) const {
    return domes == ConstantDomes::bsdf_sampling_only && is_constant_dome(lights_[i]);
  }

  static constexpr size_t kMostWeighed = 128;

  bool sample_all_ = false, has_traits_ = false;
  std::vector<Light> lights_;
  LightTree tree_;  // of more than kMostWeighed lights
  std::vector<bool> visible_to_camera_;
  std::vector<uint32_t> shadow_links_;                                 // empty: no light has one
  std::vector<LobeScales> scales_;                                     // empty: all are 1
  std::vector<uint32_t> groups_;                                       // empty: no light has one
  std::vector<uint32_t> finite_, infinite_;                            // lights that a ray can meet, by index
  std::vector<uint32_t> constant_domes_;                               // by index
  std::vector<uint32_t> shadow_linked_;                                // those with a shadow link that a ray can meet
  std::vector<std::pair<uint32_t, uint32_t>> mesh_light_of_instance_;  // sorted (instance, light index)
};

}  // namespace alabaster
