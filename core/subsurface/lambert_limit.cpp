#include "core/subsurface/lambert_limit.h"

#include <algorithm>
#include <cmath>

#include "core/math/frame.h"
#include "core/sampling/warp.h"

namespace alabaster {
namespace {

/// Mean distance between entry and exit on a slab, in mean free paths: 2 to 9 % above what walks of A = 0.2 .. 0.95
/// measure (.845, 1.378, 2.390, 4.016). Infinite without absorption.
double mean_exit_radius(double one_minus_alpha) {
  const double x = -0.5 * std::log(one_minus_alpha);
  return 0.5 + x * (0.75 + 0.055 * x);
}

/// In mean free paths. The extrapolated boundary is left out: it makes up for what diffusion theory does not see, light
/// that crosses after few collisions where absorption is strong.
double opaque_depth(double one_minus_alpha) {
  constexpr double kPeak = 4 / (3 * kLambertTolerance);
  // Diffusion's attenuation exceeds the true one, at most 1, where absorption is strong.
  const double kappa = std::min(std::sqrt(3 * one_minus_alpha), 1.0);
  return kappa > 1e-4 ? std::asinh(kPeak * kappa) / kappa : kPeak;
}

/// True if a ray of the entry's cosine lobe crosses `depth` without meeting the object's surface.
bool is_thick(const SubsurfaceBody& body, const SubsurfaceEntry& entry, float depth, const Vec2f& u,
              RenderCounters& counters) {
  const SubsurfaceBody::Member& member = body.members[entry.member];
  const SurfaceHit& hit = entry.hit;
  const Vec3f direction = frame_from_normal(-hit.ng).to_world(sample_cosine_hemisphere(u));
  ++counters.probe_rays;
  TriangleHit met;
  std::optional<SubsurfaceBody::Maps> moved;
  const Affine& to_object = member.at(entry.triangle, &moved).to_object;
  return !member.object->intersect({offset_point(hit.p_object, -hit.ng_object, hit.offset_object),
                                    to_object.vector(direction), depth, entry.triangle.time},
                                   &met);
}

/// The isotropic medium of the same A and d reaches as far (make_medium).
LightReach isotropic_reach(const Medium& medium, AlbedoInversion inversion) {
  if (medium.g == 0) return light_reach(medium);
  return light_reach(make_medium(medium.albedo, medium.scatter_distance, inversion));
}

}  // namespace

LightReach light_reach(const Medium& medium) {
  double reach = 0, depth = 0;
  for (int c = 0; c < 3; ++c) {
    if (!medium.active[c]) continue;
    const double mfp = 1 / double(medium.sigma_t[c]), complement = medium.one_minus_alpha[c];
    reach = std::max(reach, mfp * mean_exit_radius(complement));
    depth = std::max(depth, mfp * opaque_depth(complement));
  }
  return {static_cast<float>(reach), static_cast<float>(depth)};
}

float lambert_probability(float width, const LightReach& reach) {
  // The blur of p reach/(pi w) stays below the tolerance all the way; it is largest at 0.7 kFull.
  constexpr double kFull = 1.2 / (kPiDouble * kLambertTolerance);
  const double ratio = double(width) / reach.exit_radius;
  if (!(ratio > 0.25 * kFull)) return 0;
  const double x = std::min(1 + 0.5 * std::log2(ratio / kFull), 1.0);
  return static_cast<float>(x * x * (3 - 2 * x));
}

std::optional<SubsurfaceExit> LambertLimit::carry(const SubsurfaceBody& body, const SubsurfaceEntry& entry,
                                                  SubsurfaceNumbers& numbers, RenderCounters& counters) const {
  const Medium& medium = entry.medium->medium;
  // The albedo that the other inversions obtain is known for isotropic scattering alone.
  if (medium.g != 0 && inversion != AlbedoInversion::exact) return std::nullopt;
  const LightReach reach = isotropic_reach(medium, inversion);
  const auto& u = numbers.first();
  if (!(u[0] < lambert_probability(footprint, reach))) return std::nullopt;
  if (!is_thick(body, entry, reach.opaque_depth * (1 + u[1]), {u[2], u[3]}, counters)) return std::nullopt;
  ++counters.lambert_exits;
  return SubsurfaceExit{entry.triangle, entry.hit.ng, entry.throughput * obtained_albedo(medium.albedo, inversion),
                        kManyEvents};
}

}  // namespace alabaster
