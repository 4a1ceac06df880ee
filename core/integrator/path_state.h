// The state that a path carries from vertex to vertex, and the vertex.
#pragma once

#include "core/geometry/surface_hit.h"
#include "core/integrator/interiors.h"
#include "core/integrator/path_integrator.h"
#include "core/material/disney_transmissive_bsdf.h"
#include "core/math/frame.h"

namespace alabaster {

/// The width of the bundle of paths that one path stands for where it meets a surface: from the camera all paths of its
/// pixel, after a lobe a solid angle 1/pdf about the sampled direction (as in path differentials, Suykens and Willems
/// 2001). Kept where textures or gloss are filtered.
struct Footprint {
  PixelCone cone;

  void travel(float distance) { cone.width += cone.spread * distance; }
  /// GGX of this alpha reflects into 4 pi alpha^2, the reciprocal of its largest density: into the solid angle of the
  /// bundle. A narrower lobe meets a light by chance.
  float least_alpha() const { return std::min(1.0f, cone.spread * (0.5f / std::sqrt(kPi))); }
  void scatter(float pdf) {
    cone.spread = std::sqrt(cone.spread * cone.spread + (pdf > 0 ? std::min(1 / pdf, kTwoPi) : kTwoPi));
  }
};

struct PathState {
  Ray ray;  // all of a path's have one time
  Rgb throughput{1.0f};
  Rgb radiance{0.0f};
  /// Density of the ray's direction, summed over the paths that a split sent on together; 0 for the camera ray, which
  /// no light sampling competes with, and infinite after a discrete choice, with which it cannot.
  float scatter_pdf = 0;
  LightSearch search;                // at the last vertex
  const LightSet* lights = nullptr;  // that light the last vertex; of camera rays all
  uint32_t depth = 0;
  FilmSample* guides = nullptr;  // takes the values of kGuideAovs at the next surface; null: they are not sought
  bool held_out = false;         // the camera's ray ended at a hold-out
  uint32_t walk_events = 0;      // of the last subsurface walk; any other carrier of light counts as many
  Rgb twin_light{0.0f};          // that its twin took out of the path's radiance
  Footprint footprint;
  Interiors interiors;  // that the ray is in
  Hollows hollows;      // bodies that the ray is in, in air

  /// The path goes on along another ray.
  void go_on(const Vec3f& origin, const Vec3f& direction) {
    ray = {origin, direction, std::numeric_limits<float>::infinity(), ray.time};
  }
  Rgb through_interiors(const Rgb& light, float distance) const {
    return interiors.empty() ? light : light * interiors.transmittance(distance);
  }
};

/// The points from which light leaves a facet with a smooth normal. Directions above the facet leave from it.
/// Directions in the wedge below the facet's horizon, which only the lobe about the smooth normal has, leave from the
/// curved surface that the facet stands for (curvature_shift): else the facets would show as dark steps where the light
/// grazes them. Each direction has one origin, so light sampling and lobe sampling estimate the same.
struct Departure {
  Vec3f flat;             // ray origin at the facet
  Vec3f curved{0, 0, 0};  // ray origin for the wedge
  Vec3f ng;
  Vec3f n;          // of the lobe
  float wedge = 0;  // sine of the angle between facet and lobe; 0: the surface does not stand out over the facet

  bool is_above(const Vec3f& wi) const { return dot(wi, ng) > 0; }
};

/// A point on a surface as seen along a ray: all normals on the viewer's side.
struct PathVertex {
  const Instance* instance = nullptr;
  std::optional<Placement> moved = {};  // at the ray's time, of an instance that moves or is in an array
  TriangleHit triangle;
  SurfaceHit hit;
  Frame frame;          // of the lobes; the viewer is above it
  Departure departure;  // on the viewer's side, of the interpolated normal
  bool mapped = false;  // the frame is tilted by a normal map
  DisneyParameters material;
  BoundarySide boundary;  // of a material that transmits, once meet_boundary() has set it
  /// The interiors on the far side of a boundary where other bodies' surfaces lie on it. Empty: none do.
  std::optional<Interiors> past = {};

  const Placement& placement() const { return moved ? *moved : *instance; }
  /// A lobe that a normal map tilts may lead into the surface, where it has no light to fetch.
  bool is_above_surface(const Vec3f& wi) const { return !mapped || dot(wi, departure.n) > 0; }
};

/// The vertex where `ray` (unit direction, render space) met the scene. Textures are read as means over `footprint`
/// (render space; 0: at the point).
PathVertex make_vertex(const PathContext& context, const Ray& ray, const TriangleHit& triangle, float footprint = 0);

/// Random numbers of scattering at a vertex.
struct VertexNumbers {
  std::array<float, 4> light, bsdf;
};

/// A SurfaceHit or a SurfacePoint with all normals on the side that `towards` points to.
template <class Hit>
Hit on_side(Hit hit, const Vec3f& towards) {
  if (dot(hit.ng, towards) < 0) {
    hit.ng = -hit.ng;
    hit.ns = -hit.ns;
    hit.ng_object = -hit.ng_object;
  }
  return hit;
}

/// `placement`: of the instance at the hit's time.
inline SurfaceHit surface_on_side(const Instance& instance, const Placement& placement, const TriangleHit& triangle,
                                  const Vec3f& towards) {
  return on_side(surface_hit(instance.prototype->mesh, triangle, placement.object_to_world, placement.world_to_object),
                 towards);
}

/// `hit`: of `triangle`, with normals on the side that the light leaves to; `n`: the lobe's normal.
inline Departure depart(const Mesh& mesh, const Affine& object_to_world, const TriangleHit& triangle,
                        const SurfacePoint& hit, const Vec3f& n) {
  Departure d;
  d.flat = offset_point(hit.p, hit.ng, hit.offset);
  d.ng = hit.ng;
  d.n = n;
  d.curved = d.flat + curvature_shift(mesh, triangle, hit, object_to_world);
  if (d.curved != d.flat) d.wedge = length(cross(hit.ng, n));
  return d;
}

}  // namespace alabaster
