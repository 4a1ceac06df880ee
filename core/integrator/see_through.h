// Surfaces that a ray may pass without being scattered: partly opaque ones, cut-outs, the backs of single-sided ones,
// and what is culled from the camera. Asked hit by hit while the ray is traced.
#pragma once

#include "core/integrator/media.h"
#include "core/integrator/path_integrator.h"
#include "core/sampling/pixel_sampler.h"
#include "core/scene/scene.h"

namespace alabaster {

/// True where a camera's ray along `dir` does not see the hit.
bool is_culled(const Instance& instance, const TriangleHit& hit, const Vec3f& dir);

/// True if one of the interiors is of the union that `member` belongs to: the ray is in its medium.
bool is_in_union(const SceneSnapshot& scene, const MediumStack& interiors, const Instance& member);

/// The share of a hit that is there, 0 to 1, for a ray along `dir`. `within`: the interiors that the ray is in; null:
/// none. Their own surfaces, and those of their unions, have coverage 1: light within a medium ignores opacity, as
/// walks do. Partly opaque walls of a union's member within another member are not there: its surface is that of the
/// union.
float coverage_at(const SceneSnapshot& scene, const Vec3f& dir, const TriangleHit& hit, const MediumStack* within);

/// The number in AirPockets of the body that an instance belongs to: a union is one body.
uint32_t air_pocket_of(const SceneSnapshot& scene, uint32_t instance);

/// How a ray along `dir` crosses the surface of a solid that scatters or is clear, at a hit. `none`: other surfaces.
enum class Crossing { none, enters, leaves };
Crossing crossing_at(const Instance& instance, const Vec3f& dir, const TriangleHit& hit);

/// A ray of a path stops at a hit with the probability of its coverage: a function of the ray's number and the triangle
/// alone, so that it does not depend on the order in which hits are found.
class StochasticStop final : public HitFilter {
 public:
  StochasticStop(const SceneSnapshot& scene, const Vec3f& dir, const MediumStack& within, const PixelSampler& sampler,
                 uint32_t depth)
      : scene_(scene), dir_(dir), within_(within), sampler_(sampler), depth_(depth) {}
  bool stops(const TriangleHit& hit) const noexcept override;
  /// Updates the bodies that the ray is in, by the holes that it passed before `t`.
  void cross_holes(float t, AirPockets* hollows) const;
  /// The bodies that a ray is in before the holes, whether or not `hollows` has been told of them. False: it passed
  /// none.
  bool uncross_holes(AirPockets* hollows) const;

 private:
  struct Hole {
    float t;
    uint32_t instance, triangle;
    Crossing crossing;
  };
  void note_hole(const TriangleHit& hit) const;

  const SceneSnapshot& scene_;
  const Vec3f& dir_;
  const MediumStack& within_;
  const PixelSampler& sampler_;
  uint32_t depth_;
  mutable SmallStack<Hole> holes_;  // passed ones, also beyond the surface that the ray stops at
};

/// The share of light that arrives through the surfaces that a shadow ray passes: partly opaque ones, and clear sheets,
/// through which light goes straight on. The same bits in whatever order they are found: logarithms are summed in fixed
/// point. A ray through the very edge between two triangles counts both.
class Transmittance final : public HitFilter {
 public:
  /// `media`: that the ray begins in.
  Transmittance(const PathContext& context, const Vec3f& dir, const MediumStack& media)
      : context_(context), dir_(dir), media_(media) {}
  bool stops(const TriangleHit& hit) const noexcept override;
  /// If no hit stopped the ray.
  Rgb value() const;

 private:
  const PathContext& context_;
  const Vec3f& dir_;
  const MediumStack& media_;
  mutable std::array<int64_t, 3> log_{};  // base 2, in units of 2^-32
};

/// The share of the light of a shadow link that arrives along the ray. Surfaces that are not in it cast no shadow.
Rgb linked_visibility(const PathContext& context, const Ray& ray, uint32_t shadow_link, const MediumStack& media);
/// The same where shadow catchers alone cast shadows.
Rgb visibility_among_catchers(const PathContext& context, const Ray& ray, uint32_t shadow_link,
                              const MediumStack& media);

}  // namespace alabaster
