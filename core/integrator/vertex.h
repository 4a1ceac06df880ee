// A vertex of a path: a point on a surface, where light is sampled and the path goes on. make_vertex() and find_exit()
// make one, and resolve_interface() finds what lies on its sides.
#pragma once

#include "core/geometry/surface_hit.h"
#include "core/integrator/control_variate.h"
#include "core/integrator/path.h"
#include "core/material/disney_layers.h"
#include "core/material/disney_transmissive_bsdf.h"
#include "core/math/frame.h"

namespace alabaster {

/// Random numbers of a vertex.
struct VertexSamples {
  std::array<float, 4> light{}, bsdf{};
  float roulette = 0;
};

/// Where rays leave a vertex. No light lies in a direction below either plane of the horizon.
struct RayOrigin {
  Vec3f p{0, 0, 0};
  Horizon horizon{};
  float chance = 1;  // of sampling lights from it
};

/// The layers over an exit.
struct ExitLayers {
  DisneyLayers layers;
  DisneyLayers::Entered entered;  // where the path entered
  float leaving(const Vec3f& wi) const { return layers.leaving(wi, entered); }
};

struct Vertex {
  enum class Kind {
    surface,    // all lobes are on the viewer's side
    interface,  // it transmits light
    within,     // the path came through the medium, and goes on in it: there are no lobes on that side
    exit,       // of a walk: the exit lobe alone
  };
  Kind kind = Kind::surface;
  const Instance* instance = nullptr;
  std::optional<Placement> moved = {};  // at the ray's time, of an instance that moves or is in an array
  TriangleHit triangle;
  SurfaceHit hit;          // all normals on the side of the viewer, or that light leaves to; of exits a SurfacePoint
  Frame frame;             // of the lobes; that side is above it
  bool is_mapped = false;  // the frame is tilted by a normal map
  DisneyParameters material;
  VertexSamples u;

  /// Light leaves a facet with a smooth normal from two origins. Directions above the facet leave from it. Directions
  /// in the wedge below the facet's horizon, which only the lobe about the smooth normal has, leave from the curved
  /// surface that the facet stands for (curvature_shift): else the facets would show as dark steps where the light
  /// grazes them (the shadow terminator). Each direction has one origin, so light sampling and BSDF sampling estimate
  /// the same.
  enum Origin { kFacet, kSmooth, kFarSide };
  std::array<RayOrigin, 3> origins;  // kSmooth: of chance 0 where the surface does not stand out over the facet; so is
                                     // kFarSide but of interfaces that resolve_interface() has found visible

  InterfaceSide side;                         // of interfaces, once resolve_interface() has set it
  std::optional<MediumStack> beyond = {};     // the media on its far side, where other bodies' surfaces lie on it
  std::optional<AirPockets> air_beyond = {};  // as it is there, where holes of other bodies lie on it
  std::optional<ExitLayers> exit_layers = {};
  const WalkMedium* medium = nullptr;          // once find_medium() has been called
  std::optional<ControlVariate> control = {};  // of walks that enter here; empty: they have no twins

  /// Light walks in the body below, whether or not it enters here.
  bool has_medium() const { return material.has_medium() && instance->material(triangle.triangle).scatters(); }
  const Placement& placement() const { return moved ? *moved : *instance; }
  /// Interpolated, and bent towards the viewer.
  const Vec3f& smooth_normal() const { return origins[kFacet].horizon[1]; }
  bool is_above_facet(const Vec3f& wi) const { return dot(wi, hit.ng) > 0; }
  /// A lobe that a normal map tilts may lead into the surface, where it has no light to fetch.
  bool is_above_surface(const Vec3f& wi) const { return !is_mapped || dot(wi, smooth_normal()) > 0; }
  /// True if a direction on the near side may leave from the smooth surface.
  bool leaves_from_smooth(const Vec3f& wi) const { return origins[kSmooth].chance > 0 && !is_above_facet(wi); }

  /// Sets the origins of the near side. `n`: the smooth normal.
  void set_near_origins(const Vec3f& n);
  /// Finds the medium below: made at commit if no texture varies it and every distance can be resolved, else here.
  void find_medium(const IntegratorSettings& settings);

 private:
  std::optional<WalkMedium> made_medium_ = {};
};

/// The surface and the material where `ray` (unit direction, render space) met the scene. Textures are read as means
/// over `footprint` (render space; 0: at the point).
void evaluate_surface(const PathContext& context, const Ray& ray, const TriangleHit& triangle, float footprint,
                      Vertex* v);

/// The vertex where the path's ray met the scene, with the material as the render's mode and filters have it. The wall
/// of a body that is seen from inside through air is a thin sheet.
void make_vertex(const PathContext& context, const TriangleHit& triangle, const Path& path, Vertex* v);

/// Turns all normals to the side that `towards` points to.
inline void turn_towards(const Vec3f& towards, SurfacePoint* hit) {
  if (!(dot(hit->ng, towards) < 0)) return;
  hit->ng = -hit->ng;
  hit->ns = -hit->ns;
  hit->ng_object = -hit->ng_object;
}

/// A SurfaceHit or a SurfacePoint with all normals on that side.
template <class Hit>
Hit on_side(Hit hit, const Vec3f& towards) {
  turn_towards(towards, &hit);
  return hit;
}

/// `placement`: of the instance at the hit's time.
inline SurfaceHit surface_on_side(const Instance& instance, const Placement& placement, const TriangleHit& triangle,
                                  const Vec3f& towards) {
  return on_side(surface_hit(instance.prototype->mesh, triangle, placement.object_to_world, placement.world_to_object),
                 towards);
}

/// Ray origin on the far side.
inline Vec3f far_side_of(const SurfacePoint& hit) {
  return offset_point(hit.p, -hit.ng, hit.offset);
}

}  // namespace alabaster
