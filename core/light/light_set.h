// All lights of a snapshot: chooses which to sample (light_choice.h), and answers for rays that hit one.
#pragma once

#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "core/light/light.h"
#include "core/light/light_choice.h"

namespace alabaster {

class LightSet {
 public:
  LightSet() = default;
  /// `visible_to_camera[i]` belongs to lights[i]; those it lacks are visible. A set of up to `sample_all_up_to` lights
  /// is sampled whole, each light once per point (probability 1): most of a light's samples that face away cost no ray,
  /// and no light's noise is paid for another's. Larger sets choose one.
  LightSet(std::vector<Light> lights, std::vector<bool> visible_to_camera, size_t sample_all_up_to = 0);

  bool empty() const { return lights_.empty(); }
  size_t size() const { return lights_.size(); }

  /// One direction for each light to be sampled at p (all, or the chosen one): visit(const LightSample&), pdf with the
  /// choice in it. u: the choice, then the direction.
  template <class Visit>
  void sample_lights(const Vec3f& p, const std::array<float, 4>& u, const Visit& visit) const {
    if (!sample_all_) {
      if (const auto s = sample(p, u[0], {u[1], u[2]})) visit(*s);
      return;
    }
    for (size_t i = 0; i < lights_.size(); ++i)
      if (const auto s = sample_light(i, p, shifted({u[1], u[2]}, i))) visit(*s);
  }

  /// One light by choice, one direction. pdf already includes the choice of light (also for a delta light). Empty:
  /// nothing to gain here.
  std::optional<LightSample> sample(const Vec3f& p, float u_light, const Vec2f& u) const;

  /// Sum of what analytic lights nearer than ray.tmax (rect, sphere) or, when `escaped`, at infinity (distant, dome)
  /// emit along the ray. Lights do not block rays: all are added, each weighed by `weigh(pdf)`, the pdf that
  /// sample_lights(ray.org, ...) has for this direction of this light, with the choice in it.
  template <class Weigh>
  Rgb emitted(const Ray& ray, bool escaped, bool camera_ray, const Weigh& weigh) const {
    Rgb sum(0.0f);
    std::optional<LightChoice> choice;  // most rays meet no light
    for (size_t i = 0; i < lights_.size(); ++i) {
      if (camera_ray && !visible_to_camera_[i]) continue;
      const auto hit = intersect(i, ray);
      if (!hit || (std::isinf(hit->t) ? !escaped : hit->t > ray.tmax)) continue;
      if (!choice && !sample_all_) choice.emplace(lights_, ray.org);
      sum += hit->radiance * weigh(sample_all_ ? hit->pdf : hit->pdf * choice->probability(i));
    }
    return sum;
  }

  /// pdf (with the choice in it) that sample_lights(ray.org, ...) has for the point of an emissive triangle that the
  /// ray of unit direction hit at distance t; 0 if it is no light.
  float mesh_light_pdf(const Ray& ray, float t, uint32_t instance, uint32_t triangle) const;

  const std::vector<Light>& lights() const { return lights_; }
  /// Probability that sample(p, ...) chooses light i.
  float choice_probability(size_t i, const Vec3f& p) const { return LightChoice(lights_, p).probability(i); }

 private:
  std::optional<LightHit> intersect(size_t i, const Ray& ray) const;
  std::optional<LightSample> sample_light(size_t i, const Vec3f& p, const Vec2f& u) const;
  /// Another point of the unit square for each light, as well spread as u is (Roberts' R2 lattice as a shift).
  static Vec2f shifted(const Vec2f& u, size_t i);

  bool sample_all_ = false;
  std::vector<Light> lights_;
  std::vector<bool> visible_to_camera_;
  std::vector<std::pair<uint32_t, uint32_t>> mesh_light_of_instance_;  // sorted (instance, light index)
};

}  // namespace alabaster
