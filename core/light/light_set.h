// All lights of a snapshot: chooses which to sample (light_choice.h), and answers for rays that hit one.
#pragma once

#include <cmath>
#include <utility>
#include <vector>

#include "core/light/light.h"
#include "core/light/light_choice.h"

namespace alabaster {

class LightSet {
 public:
  LightSet() = default;
  /// `visible_to_camera[i]` belongs to lights[i]; those it lacks are visible.
  LightSet(std::vector<Light> lights, std::vector<bool> visible_to_camera);

  bool empty() const { return lights_.empty(); }
  size_t size() const { return lights_.size(); }

  /// One light, one direction. pdf already includes the choice of light (also for a delta light). Empty: nothing to
  /// gain here.
  std::optional<LightSample> sample(const Vec3f& p, float u_light, const Vec2f& u) const;

  /// Sum of what analytic lights nearer than ray.tmax (rect, sphere) or, when `escaped`, at infinity (distant, dome)
  /// emit along the ray. Lights do not block rays: all are added, each weighed by `weigh(pdf)`, the pdf that
  /// sample(ray.org, ...) has for this direction of this light, with the choice in it.
  template <class Weigh>
  Rgb emitted(const Ray& ray, bool escaped, bool camera_ray, const Weigh& weigh) const {
    Rgb sum(0.0f);
    std::optional<LightChoice> choice;  // most rays meet no light
    for (size_t i = 0; i < lights_.size(); ++i) {
      if (camera_ray && !visible_to_camera_[i]) continue;
      const auto hit = intersect(i, ray);
      if (!hit || (std::isinf(hit->t) ? !escaped : hit->t > ray.tmax)) continue;
      if (!choice) choice.emplace(lights_, ray.org);
      sum += hit->radiance * weigh(hit->pdf * choice->probability(i));
    }
    return sum;
  }

  /// pdf (with the choice in it) that sample(ray.org, ...) has for the point of an emissive triangle that the ray of
  /// unit direction hit at distance t; 0 if it is no light.
  float mesh_light_pdf(const Ray& ray, float t, uint32_t instance, uint32_t triangle) const;

  const std::vector<Light>& lights() const { return lights_; }
  /// Probability that sample(p, ...) chooses light i.
  float choice_probability(size_t i, const Vec3f& p) const { return LightChoice(lights_, p).probability(i); }

 private:
  std::optional<LightHit> intersect(size_t i, const Ray& ray) const;
  std::vector<Light> lights_;
  std::vector<bool> visible_to_camera_;
  std::vector<std::pair<uint32_t, uint32_t>> mesh_light_of_instance_;  // sorted (instance, light index)
};

}  // namespace alabaster
