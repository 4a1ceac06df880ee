// Surfaces that a ray may pass without being scattered: partly opaque ones, cut-outs, the backs of single-sided ones,
// and what is culled from the camera. Asked hit by hit while the ray is traced.
#pragma once

#include "core/sampling/pixel_sampler.h"
#include "core/scene/scene.h"

namespace alabaster {

/// True where a camera's ray along `dir` does not see the hit.
bool is_culled(const Instance& instance, const TriangleHit& hit, const Vec3f& dir);

/// The share of a hit that is there, 0 to 1, for a ray along `dir`.
float coverage_at(const SceneSnapshot& scene, const Vec3f& dir, const TriangleHit& hit);

/// A ray of a path stops at a hit with the probability of its coverage: a function of the ray's number and the triangle
/// alone, so that it does not depend on the order in which hits are found.
class StochasticStop final : public HitFilter {
 public:
  StochasticStop(const SceneSnapshot& scene, const Vec3f& dir, const PixelSampler& sampler, uint32_t depth)
      : scene_(scene), dir_(dir), sampler_(sampler), depth_(depth) {}
  bool stops(const TriangleHit& hit) const noexcept override;

 private:
  const SceneSnapshot& scene_;
  const Vec3f& dir_;
  const PixelSampler& sampler_;
  uint32_t depth_;
};

/// The share of light that arrives through the surfaces that a shadow ray passes. The same bits in whatever order they
/// are found: logarithms are summed in fixed point. A ray through the very edge between two triangles counts both.
class Transmittance final : public HitFilter {
 public:
  Transmittance(const SceneSnapshot& scene, const Vec3f& dir) : scene_(scene), dir_(dir) {}
  bool stops(const TriangleHit& hit) const noexcept override;
  /// If no hit stopped the ray.
  float value() const;

 private:
  const SceneSnapshot& scene_;
  const Vec3f& dir_;
  mutable int64_t log_ = 0;  // base 2, in units of 2^-32
};

/// The share of the light of a shadow link that arrives along the ray. Surfaces that are not in it cast no shadow.
float linked_visibility(const SceneSnapshot& scene, const Ray& ray, uint32_t shadow_link);

}  // namespace alabaster
