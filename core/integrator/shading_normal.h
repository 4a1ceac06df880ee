// The normal of the lobes at a hit: the interpolated one, or that of a normal map, never such that the viewer's mirror
// image lies below the surface.
#pragma once

#include "core/scene/scene.h"

namespace alabaster {

/// `ns` bent until `wo` is just above it: an interpolated normal may turn away from the viewer at a silhouette. It need
/// not be farther above it than above the facet of normal `ng`: a flat surface that is seen at a grazing angle is not
/// bent, down to where the rounding of normals counts.
inline Vec3f bend_towards(const Vec3f& ns, const Vec3f& ng, const Vec3f& wo) {
  constexpr float kLeastCosine = 0.01f, kLeastOfFacet = 1e-4f;
  const float cosine = dot(ns, wo);
  if (cosine >= kLeastCosine) return ns;
  const float least = std::clamp(dot(ng, wo), kLeastOfFacet, kLeastCosine);
  return cosine >= least ? ns : normalize(ns + wo * (least - cosine));
}

/// The normal of a normal or bump map at a hit, on the side of `side`, whose normals have been turned to the viewer (or
/// to where light leaves); `ns` if the mesh has no tangents there, or a bump map's texture coordinates no gradient.
/// Heights tilt the normal against their gradient over the surface (Mikkelsen 2010, "Bump Mapping Unparametrized
/// Surfaces on the GPU"), by differences over one texel.
Vec3f mapped_normal(const Instance& instance, const Placement& placement, const TriangleHit& triangle,
                    const SurfaceHit& side, const NormalMap& map);

/// True if texture coordinates wind clockwise in a frame whose s lies along growing u and whose normal is on the side
/// of `side`: then v grows against its t. Meshes without texture coordinates count as if v grew counter-clockwise.
bool winds_clockwise(const Instance& instance, const Placement& placement, const TriangleHit& triangle,
                     const SurfaceHit& side);

/// The unit normal nearest to `n` about which the mirror image of `wo` lies above the plane of `surface`: else a facet
/// of the map reflects only into its own surface, and shows black (Keller et al. 2017, "The Iray Light Transport
/// Simulation and Rendering System", section A.3). wo above `surface`.
Vec3f reflecting_normal(const Vec3f& n, const Vec3f& surface, const Vec3f& wo);

}  // namespace alabaster
