// All lights of a snapshot: chooses which to sample, and answers for rays that hit one. The choice is by power, mixed
// with a uniform choice among the lights that give any light (a lamp in a corner must not starve beside a dome over a
// large scene); a light tree may come later behind the same calls.
#pragma once

#include <cmath>
#include <utility>
#include <vector>

#include "core/light/light.h"

namespace alabaster {

class LightSet {
 public:
  LightSet() = default;
  /// `visible_to_camera[i]` belongs to lights[i]; those it lacks are visible. `scene_radius`: radius of the scene's
  /// bounding sphere (for power of distant and dome lights); anything but a positive number counts as 1.
  LightSet(std::vector<Light> lights, std::vector<bool> visible_to_camera, float scene_radius);

  bool empty() const { return lights_.empty(); }
  size_t size() const { return lights_.size(); }

  /// One light, one direction. pdf already includes the choice of light (also for a delta light). Empty: nothing to
  /// gain here.
  std::optional<LightSample> sample(const Vec3f& p, float u_light, const Vec2f& u) const;

  /// Sum of what analytic lights nearer than ray.tmax (rect, sphere) or, when `escaped`, at infinity (distant, dome)
  /// emit along the ray. Lights do not block rays: all are added, each weighed by `weigh(pdf_including_choice)`.
  template <class Weigh>
  Rgb emitted(const Ray& ray, bool escaped, bool camera_ray, const Weigh& weigh) const {
    Rgb sum(0.0f);
    for (size_t i = 0; i < lights_.size(); ++i) {
      if (camera_ray && !visible_to_camera_[i]) continue;
      const auto hit = intersect(i, ray);
      if (!hit || (std::isinf(hit->t) ? !escaped : hit->t > ray.tmax)) continue;
      sum += hit->radiance * weigh(hit->pdf * choice_probability(i));
    }
    return sum;
  }

  /// pdf (including the choice) of having sampled the emissive triangle that a ray from p hit; 0 if it is no light.
  float mesh_light_pdf(uint32_t instance, uint32_t triangle, const Vec3f& wi, float t) const;

  const std::vector<Light>& lights() const { return lights_; }
  /// Probability that sample() chooses light i; 0 exactly for lights that give no light.
  float choice_probability(size_t i) const { return has_power_ ? choice_.probability(i) : 0; }

 private:
  std::optional<LightHit> intersect(size_t i, const Ray& ray) const;
  std::vector<Light> lights_;
  std::vector<bool> visible_to_camera_;
  Distribution1D choice_;
  bool has_power_ = false;
  std::vector<std::pair<uint32_t, uint32_t>> mesh_light_of_instance_;  // sorted (instance, light index)
};

}  // namespace alabaster
