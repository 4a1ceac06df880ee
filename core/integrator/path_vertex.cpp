#include "core/integrator/path_state.h"
#include "core/integrator/shading_normal.h"

namespace alabaster {

namespace {

// Counter-clockwise about the normal.
Frame turned(const Frame& frame, float turns) {
  const float angle = (turns - std::floor(turns)) * 2 * float(M_PI);
  return frame_from_normal_tangent(frame.n, frame.s * std::cos(angle) + frame.t * std::sin(angle));
}

}  // namespace

PathVertex make_vertex(const PathContext& context, const Ray& ray, const TriangleHit& triangle, float footprint) {
  PathVertex v;
  v.instance = &context.scene.instance(triangle.instance);
  v.triangle = triangle;
  const Vec3f wo = -ray.dir;
  const Placement& placement = v.instance->at(triangle, &v.moved);
  const Mesh& mesh = v.instance->prototype->mesh;
  v.hit = surface_on_side(*v.instance, placement, triangle, wo);
  const Vec3f surface = bend_towards(v.hit.ns, v.hit.ng, wo);
  v.departure = depart(mesh, placement.object_to_world, triangle, v.hit, surface);
  const DisneyMaterial& material = v.instance->material(triangle.triangle);
  v.mapped = material.normal_map.has_value();
  const auto mapped = [&](const NormalMap& map) {
    return reflecting_normal(mapped_normal(*v.instance, placement, triangle, v.hit, map), surface, wo);
  };
  const Vec3f n = v.mapped ? mapped(*material.normal_map) : surface;
  v.frame = frame_from_normal_tangent(n, v.hit.dpdu);
  v.material = material.evaluate({mesh, triangle, v.hit.uv, {footprint, &placement.object_to_world}});
  if (v.material.anisotropic > 0 && !has_direction_of_u(mesh, triangle.triangle)) [[unlikely]]
    v.frame = frame_from_normal_tangent(n, stand_in_tangent(v.hit, placement.object_to_world));
  if (v.material.anisotropic_rotation != 0) [[unlikely]] {
    const bool clockwise = winds_clockwise(*v.instance, placement, triangle, v.hit);
    v.frame = turned(v.frame, v.material.anisotropic_rotation * (clockwise ? -1.0f : 1.0f));
  }
  if (v.material.coat > 0 && (v.mapped || material.coat_normal_map)) {
    Vec3f coat = surface;
    if (material.coat_normal_map) coat = mapped(*material.coat_normal_map);
    v.material.coat_normal = v.frame.to_local(coat);
    v.material.surface_normal = v.mapped ? v.frame.to_local(surface) : Vec3f(0, 0, 1);
  }
  return v;
}

}  // namespace alabaster
