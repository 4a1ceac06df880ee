// The next surface of a path: where its ray ends, with the material as the render's mode and filters have it.
#pragma once

#include <cmath>

#include "core/integrator/path_state.h"
#include "core/integrator/see_through.h"
#include "core/integrator/subsurface_scatter.h"
#include "core/subsurface/body.h"

namespace alabaster {

/// The nearest surface that stops the path's ray. Updates path->hollows by the holes on the way.
inline bool trace(const PathContext& context, const PixelSampler& sampler, PathState* path, TriangleHit* hit) {
  if (!context.scene.top->intersect(path->ray, hit)) return false;
  if (!context.sees_through()) return true;
  // Most rays stop at the first surface. Only the others ask at all that they meet.
  const StochasticStop filter(context.scene, path->ray.dir, path->interiors, sampler, path->depth);
  if (filter.stops(*hit)) return true;
  const bool found = context.scene.top->intersect(path->ray, hit, &filter);
  filter.cross_holes(found ? hit->t : std::numeric_limits<float>::infinity(), &path->hollows);
  return found;
}

inline bool keeps_footprints(const PathContext& context) {
  return context.settings.texture_filter > 0 || context.settings.glossy_filter > 0;
}

/// True if the path came to the vertex through the medium and goes on in it. A diffusion profile has no way through the
/// medium, only ways into it.
template <SubsurfaceMode kMode>
bool continues_within_medium(const PathContext& context, const PathVertex& v, const PathState& path) {
  if constexpr (kMode == SubsurfaceMode::walk) return is_within_medium(context, v, path);
  return false;
}

/// True if the path is in the body of the instance that it meets, in air: it came through a hole, or it left another
/// body within. (It left a clear body of holes by its interior.)
inline bool is_in_air_within(const PathContext& context, const PathVertex& v, const PathState& path) {
  const SubsurfaceBody* const body = v.instance->body;
  const bool began_there = path.depth > 0 && body && body->has_holes && !v.material.transmits();
  if (!began_there && (path.hollows.empty() || !path.hollows.contains(hollow_of(context.scene, v.triangle.instance))))
    return false;
  return crossing_at(*v.instance, path.ray.dir, v.triangle) == Crossing::leaves &&
         !is_in_union(context.scene, path.interiors, *v.instance);
}

/// The path's vertex on a surface that its ray has met. The wall of a body that is seen from inside through air is a
/// thin sheet.
template <SubsurfaceMode kMode>
PathVertex vertex_on(const PathContext& context, const TriangleHit& hit, const PathState& path) {
  PathVertex vertex = make_vertex(context, path.ray, hit, context.settings.texture_filter * path.footprint.cone.width);
  if (context.settings.glossy_filter > 0 && path.depth > 0) [[unlikely]]
    vertex.material.least_roughness = std::sqrt(context.settings.glossy_filter * path.footprint.least_alpha());
  if (context.sees_through() && is_in_air_within(context, vertex, path)) [[unlikely]]
    vertex.material.thin = true, vertex.material.flatness = 0;
  if (kMode == SubsurfaceMode::lambert)
    vertex.material.scatter_distance = Rgb(0.0f);
  else if (vertex.material.scatters())
    drop_unresolved_distances(&vertex);
  return vertex;
}

/// vertex_on() the surface where the path's ray ends.
template <SubsurfaceMode kMode>
PathVertex find_vertex(const PathContext& context, const TriangleHit& hit, PathState* path) {
  if (keeps_footprints(context)) path->footprint.travel(hit.t);
  return vertex_on<kMode>(context, hit, *path);
}

}  // namespace alabaster
