// All lights of a snapshot: chooses which to sample (light_choice.h), and answers for rays that hit one.
#pragma once

#include <array>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/light/light.h"
#include "core/light/light_choice.h"
#include "core/light/light_tree.h"

namespace alabaster {

/// Who looks for a dome without an image. A lobe that is sampled whole, as every direction of its own, finds it with
/// less noise than a density that knows no lobe, and without a shadow ray. Where a lobe is chosen rarely, beside a walk
/// below the surface, light sampling must look for it too.
enum class ConstantDomes { sampled, left_to_lobes };

/// How lights are sampled at a point. The pdf of a light that a ray from there meets must be asked with the same
/// search.
struct LightSearch {
  LightSearch(ConstantDomes how = ConstantDomes::sampled, const Vec3f& lobe = Vec3f(0, 0, 0)) : domes(how), n(lobe) {}
  ConstantDomes domes;
  Vec3f n;  // unit: a lobe weighs light by the cosine to it; zero: none does
};

/// Unit normals of two planes through a point: of its surface and of its lobe. A light that lies wholly below either
/// gives nothing there.
using Horizon = std::array<Vec3f, 2>;

class LightSet {
 public:
  LightSet() = default;
  /// Beside each light, by its index.
  struct Traits {
    std::vector<bool> visible_to_camera;  // lights beyond its end are visible
    std::vector<uint32_t> shadow_links;   // of LightDescription; lights beyond its end have none
  };
  /// A set of at most `sample_all_up_to` lights samples every light once per point, with probability 1: a sample that
  /// faces away mostly costs no ray, and no light adds to another's noise. A larger set chooses one light per point,
  /// and a set of more than kMostWeighed lights chooses it by a tree.
  LightSet(std::vector<Light> lights, Traits traits, size_t sample_all_up_to = 0);

  size_t size() const { return lights_.size(); }

  /// One direction for each light to be sampled at p (all, or the chosen one): visit(const LightSample&), pdf with the
  /// choice in it. A set that samples all leaves out those below the horizon. u: the choice, then the direction.
  template <class Visit>
  void sample_lights(const Vec3f& p, const Horizon& horizon, const std::array<float, 4>& u, const LightSearch& search,
                     const Visit& visit) const {
    if (!sample_all_) {
      if (const auto s = sample(p, u[0], {u[1], u[2]}, search.n)) visit(*s);
      return;
    }
    for (size_t i = 0; i < lights_.size(); ++i) {
      if (is_left(search.domes, i) || is_below(i, p, horizon)) continue;
      if (auto s = sample_light(i, p, shifted({u[1], u[2]}, i), search.n)) {
        s->left_to_lobes = is_left(ConstantDomes::left_to_lobes, i);
        visit(std::as_const(*s));
      }
    }
  }

  /// One direction of one chosen light. The pdf includes the choice of light, for a delta light too. Empty: no light
  /// arrives.
  std::optional<LightSample> sample(const Vec3f& p, float u_light, const Vec2f& u,
                                    const Vec3f& n = Vec3f(0, 0, 0)) const;

  /// Sum of the light that lights without geometry emit along the ray: finite ones nearer than ray.tmax
  /// and, if the ray `escaped` from the scene, infinite ones (distant, dome). Lights do not block rays: all are added,
  /// each weighed by `weigh(pdf)` or `weigh(pdf, distance)`, the pdf that sample_lights(ray.org, u, search, ...) has
  /// for this direction of this light, with the choice in it. Lights with a shadow link are left out, but of camera
  /// rays.
  template <class Weigh>
  Rgb emitted(const Ray& ray, bool escaped, bool camera_ray, const LightSearch& search, const Weigh& weigh) const {
    Rgb sum(0.0f);
    std::optional<LightChoice> choice;  // most rays meet no light
    const auto weight = [&](float pdf, float distance) {
      if constexpr (std::is_invocable_v<const Weigh&, float, float>)
        return weigh(pdf, distance);
      else
        return weigh(pdf);
    };
    const auto add = [&](size_t i) {
      if (camera_ray && !visible_to_camera_[i]) return;
      const auto hit = intersect(i, ray, search.n);
      if (!hit || (hit->t > ray.tmax && !is_infinite(i))) return;  // clipping cuts no sky off
      sum += hit->radiance * weight(pdf_of(i, *hit, ray.org, search.domes, &choice), hit->t);
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
    return sum;
  }

  /// The numbers with which sample_cosine_hemisphere, about the lobe, gives the direction of a constant dome that
  /// sample_lights(p, ., u, ...) gives. Empty: there is none, one light is chosen of many, or all others together give
  /// more at p, unoccluded. That depends on p alone.
  std::optional<Vec2f> leading_dome_numbers(const Vec3f& p, const std::array<float, 4>& u) const;

  bool has_shadow_links() const { return !shadow_linked_.empty(); }
  /// The same sum for a ray that is no camera ray, of the lights with a shadow link. No surface stops them here:
  /// Rgb `arrives(shadow_link, distance)` is the share of the light that does.
  template <class Weigh, class Arrives>
  Rgb emitted_with_links(const Ray& ray, const LightSearch& search, const Weigh& weigh, const Arrives& arrives) const {
    Rgb sum(0.0f);
    std::optional<LightChoice> choice;
    for (const uint32_t i : shadow_linked_) {
      const auto hit = intersect(i, ray, search.n);
      if (!hit) continue;
      const Rgb share = arrives(shadow_links_[i], hit->t);
      if (!is_black(share)) sum += hit->radiance * share * weigh(pdf_of(i, *hit, ray.org, search.domes, &choice));
    }
    return sum;
  }

  /// pdf (with the choice in it) that sample_lights(ray.org, ...) has for the point of an emissive triangle that the
  /// ray of unit direction hit at distance t; 0 if it is no light.
  float mesh_light_pdf(const Ray& ray, float t, uint32_t instance, uint32_t triangle) const;

  const std::vector<Light>& lights() const { return lights_; }
  /// On the heap, without textures, which others may share.
  size_t memory_bytes() const;
  /// Probability that sample(p, ...) chooses light i.
  float choice_probability(size_t i, const Vec3f& p) const {
    return tree_.empty() ? LightChoice(lights_, p).probability(i) : tree_.probability(lights_, p, i);
  }

 private:
  std::optional<LightHit> intersect(size_t i, const Ray& ray, const Vec3f& n) const;
  std::optional<LightSample> sample_light(size_t i, const Vec3f& p, const Vec2f& u, const Vec3f& n) const;
  /// Another point of the unit square for each light, as well spread as u: shifted by Roberts' R2 lattice.
  static Vec2f shifted(const Vec2f& u, size_t i);
  bool is_below(size_t i, const Vec3f& p, const Horizon& horizon) const;
  bool is_infinite(size_t i) const {
    return std::holds_alternative<DistantLight>(lights_[i]) || std::holds_alternative<DomeLight>(lights_[i]);
  }
  /// The pdf that sample_lights(p, ...) has for a light i that a ray has met. `choice` is kept between calls.
  float pdf_of(size_t i, const LightHit& hit, const Vec3f& p, ConstantDomes domes,
               std::optional<LightChoice>* choice) const {
    if (is_left(domes, i)) return 0;
    if (sample_all_) return hit.pdf;
    if (!tree_.empty()) return hit.pdf * tree_.probability(lights_, p, i);
    if (!*choice) choice->emplace(lights_, p);
    return hit.pdf * (*choice)->probability(i);
  }
  /// Where one light of many is chosen, constant domes are chosen as others are.
  bool is_left(ConstantDomes domes, size_t i) const {
    if (domes == ConstantDomes::sampled || !sample_all_) return false;
    const auto* dome = std::get_if<DomeLight>(&lights_[i]);
    return dome && !dome->image();
  }

  static constexpr size_t kMostWeighed = 128;

  bool sample_all_ = false;
  std::vector<Light> lights_;
  LightTree tree_;  // of more than kMostWeighed lights
  std::vector<bool> visible_to_camera_;
  std::vector<uint32_t> shadow_links_;                                 // empty: no light has one
  std::vector<uint32_t> finite_, infinite_;                            // lights that a ray can meet, by index
  std::optional<uint32_t> constant_dome_;                              // the first, of a set that samples all
  std::vector<uint32_t> shadow_linked_;                                // the same, of those with a shadow link
  std::vector<std::pair<uint32_t, uint32_t>> mesh_light_of_instance_;  // sorted (instance, light index)
};

}  // namespace alabaster
