#include "core/integrator/vertex.h"

#include <cmath>

#include "core/diagnostics/check.h"
#include "core/integrator/see_through.h"
#include "core/integrator/shading_normal.h"
#include "core/integrator/subsurface_scatter.h"
#include "core/subsurface/body.h"
#include "core/subsurface/walk_plan.h"

namespace alabaster {

namespace {

// Counter-clockwise about the normal.
Frame turned(const Frame& frame, float turns) {
  const float angle = (turns - std::floor(turns)) * 2 * float(M_PI);
  return frame_from_normal_tangent(frame.n, frame.s * std::cos(angle) + frame.t * std::sin(angle));
}

// True if the path is in the body of the instance that it meets, in air: it came through a hole, or it left another
// body within. (It left a clear body of holes by its interior.) A walk notes no holes: but for one it would have met
// the wall of what it is in, and the path would have that interior.
bool is_in_air_within(const PathContext& context, const Vertex& v, const Path& path) {
  const SubsurfaceBody* const body = v.instance->body;
  const bool began_there = path.depth > 0 && body && body->has_holes && !v.material.transmits();
  const bool has_walked =
      v.instance->see_through && is_cloudy(context, path.media) && !path.media.contains(v.triangle.instance);
  if (!began_there && !has_walked &&
      (path.air.empty() || !path.air.contains(air_pocket_of(context.scene, v.triangle.instance))))
    return false;
  return crossing_at(*v.instance, path.ray.dir, v.triangle) == Crossing::leaves &&
         !is_in_union(context.scene, path.media, *v.instance);
}

}  // namespace

void Vertex::set_near_origins(const Vec3f& n) {
  RayOrigin &facet = origins[kFacet], &smooth = origins[kSmooth];
  facet.p = offset_point(hit.p, hit.ng, hit.offset);
  facet.horizon = {hit.ng, n};
  smooth.p = facet.p + curvature_shift(instance->prototype->mesh, triangle, hit, placement().object_to_world);
  smooth.chance = origins[kFarSide].chance = 0;
  if (smooth.p == facet.p) return;
  smooth.horizon = {n, n};
  smooth.chance = std::min(1.0f, 8 * length(cross(hit.ng, n)));  // small where the mesh is fine
}

void Vertex::find_medium(const IntegratorSettings& settings) {
  if (medium) return;
  CHECK(instance->body);
  CHECK_LT(instance->member, instance->body->members.size());
  const auto& member = instance->body->members[instance->member];
  const size_t slot = instance->slot(triangle.triangle);
  const WalkMedium* const known = member.media[slot] ? &(*member.media[slot])[settings.inversion] : nullptr;
  if (known && material.scatter_distance == known->medium.scatter_distance) {
    medium = known;
    return;
  }
  medium = &made_medium_.emplace(
      make_medium(material.medium_albedo(), material.scatter_distance, settings.inversion, material.scatter_anisotropy),
      possible_shortcuts(settings.walk, *instance->body, instance->member));
}

void evaluate_surface(const PathContext& context, const Ray& ray, const TriangleHit& triangle, float footprint,
                      Vertex* v) {
  // Find the surface.
  v->instance = &context.scene.instance(triangle.instance);
  v->moved.reset();
  v->triangle = triangle;
  const Vec3f wo = -ray.dir;
  const Placement& placement = v->instance->at(triangle, &v->moved);
  const Mesh& mesh = v->instance->prototype->mesh;
  v->hit = surface_hit(mesh, triangle, placement.object_to_world, placement.world_to_object);
  turn_towards(wo, &v->hit);
  const Vec3f smooth = bend_towards(v->hit.ns, v->hit.ng, wo);
  v->set_near_origins(smooth);

  // Find the frame of the lobes, and evaluate the material.
  const DisneyMaterial& material = v->instance->material(triangle.triangle);
  v->is_mapped = material.normal_map.has_value();
  const auto mapped = [&](const NormalMap& map) {
    return reflecting_normal(mapped_normal(*v->instance, placement, triangle, v->hit, map), smooth, wo);
  };
  const Vec3f n = v->is_mapped ? mapped(*material.normal_map) : smooth;
  v->frame = frame_from_normal_tangent(n, v->hit.dpdu);
  material.evaluate(v->instance->primvars_at(triangle, v->hit.uv, {footprint, &placement.object_to_world}),
                    &v->material);
  if (v->material.anisotropic > 0 && !has_direction_of_u(mesh, triangle.triangle)) [[unlikely]]
    v->frame = frame_from_normal_tangent(n, stand_in_tangent(v->hit, placement.object_to_world));
  if (v->material.anisotropic_rotation != 0) [[unlikely]] {
    const bool clockwise = winds_clockwise(*v->instance, placement, triangle, v->hit);
    v->frame = turned(v->frame, v->material.anisotropic_rotation * (clockwise ? -1.0f : 1.0f));
  }
  if (v->material.coat > 0 && (v->is_mapped || material.coat_normal_map)) {
    Vec3f coat = smooth;
    if (material.coat_normal_map) coat = mapped(*material.coat_normal_map);
    v->material.coat_normal = v->frame.to_local(coat);
    v->material.surface_normal = v->is_mapped ? v->frame.to_local(smooth) : Vec3f(0, 0, 1);
  }

  v->side = {};
  v->beyond.reset();
  v->air_beyond.reset();
  v->medium = nullptr;
  v->control.reset();
}

void make_vertex(const PathContext& context, const TriangleHit& triangle, const Path& path, Vertex* v) {
  evaluate_surface(context, path.ray, triangle, context.settings.texture_filter * path.footprint.cone.width, v);
  if (context.settings.glossy_filter > 0 && path.depth > 0) [[unlikely]]
    v->material.least_roughness = std::sqrt(context.settings.glossy_filter * path.footprint.least_alpha());
  if (context.sees_through() && is_in_air_within(context, *v, path)) [[unlikely]] {
    v->material.base_color = v->material.mixed_color();
    v->material.thin = true, v->material.flatness = 0;
  }
  if (context.mode() == SubsurfaceMode::lambert)
    v->material.scatter_distance = Rgb(0.0f);
  else if (v->material.has_medium())
    drop_unresolved_distances(v);
  v->kind = v->material.transmits() ? Vertex::Kind::interface : Vertex::Kind::surface;
}

}  // namespace alabaster
