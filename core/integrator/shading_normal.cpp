#include "core/integrator/shading_normal.h"

namespace alabaster {
namespace {

bool mirrors(const Placement& placement) {
  const Affine& m = placement.object_to_world;
  return dot(cross(m.x, m.y), m.z) < 0;
}

// A tangent of the mesh at rest goes with its triangle, as a combination of two edges.
Vec3f deformed(const Vec3f& tangent, const Mesh& mesh, const TriangleHit& hit) {
  const auto edges = [&](float time) {
    const auto [p0, p1, p2] = mesh.corners_at(hit.triangle, time);
    return std::array<Vec3d, 2>{Vec3d(p1) - Vec3d(p0), Vec3d(p2) - Vec3d(p0)};
  };
  const auto [a, b] = edges(0);
  const auto [c, d] = edges(hit.time);
  const Vec3d n = cross(a, b), t(tangent);
  const double n2 = dot(n, n);
  if (!(n2 > 0)) return tangent;
  return Vec3f(c * (dot(cross(t, b), n) / n2) + d * (dot(cross(a, t), n) / n2));
}

Vec3f bumped_normal(const Instance& instance, const Placement& placement, const TriangleHit& hit,
                    const SurfaceHit& side, const NormalMap& map) {
  const Mesh& mesh = instance.prototype->mesh;
  const UvSet* const uvs = mesh.uv_set(map.primvar);
  if (!uvs || !map.image) return side.ns;
  const auto [p0, p1, p2] = mesh.corners_at(hit.triangle, hit.time);
  const Corners& c = corners_of(*uvs, mesh, hit.triangle);
  const Vec3f e1 = p1 - p0, e2 = p2 - p0;
  const auto place = [&](uint32_t corner) { return map.transform(uvs->values[corner]); };
  const Vec2f st0 = place(c[0]), d1 = place(c[1]) - st0, d2 = place(c[2]) - st0;
  const Vec2f st = map.transform(interpolated(*uvs, mesh, hit));
  const Vec2f texel(1 / static_cast<float>(map.image->width()), 1 / static_cast<float>(map.image->height()));
  const auto slope = [&](const Vec2f& half) {
    return map.value(st + half, map.channel) - map.value(st - half, map.channel);
  };
  const Vec2f gradient(slope({texel.x / 2, 0}) / texel.x, slope({0, texel.y / 2}) / texel.y);
  const float behind = is_behind(instance, hit, -side.ng) ? -1.0f : 1.0f;
  const Vec3f n = normalize(placement.object_to_world.transpose_vector(side.ns * behind));
  const Vec3f across = cross(e2, n);
  const Vec3f rise = across * gradient.dot(d1) + cross(n, e1) * gradient.dot(d2);
  const Vec3f bumped = placement.world_to_object.transpose_vector(n * dot(e1, across) - rise);
  const float l2 = dot(bumped, bumped);
  // dot(e1, across) is negative where the normal leans over the facet's horizon: there the normal stays.
  if (!(dot(e1, across) > 0) || !(l2 > 0) || !std::isfinite(l2)) return side.ns;
  return bumped * (behind / std::sqrt(l2));
}

}  // namespace

Vec3f mapped_normal(const Instance& instance, const Placement& placement, const TriangleHit& triangle,
                    const SurfaceHit& side, const NormalMap& map) {
  if (map.is_bump) return bumped_normal(instance, placement, triangle, side, map);
  const Mesh& mesh = instance.prototype->mesh;
  const MeshAttribute<Vec4f>* const tangents = instance.tangents_for(map);
  if (!tangents) return side.ns;
  const Vec4f tangent = interpolated(*tangents, mesh, triangle);
  const Affine& to_render = placement.object_to_world;
  const Vec3f t_object(tangent.x, tangent.y, tangent.z);
  const Vec3f along = to_render.vector(mesh.deforms() ? deformed(t_object, mesh, triangle) : t_object);
  const Vec3f across = along - side.ns * dot(along, side.ns);
  if (!(dot(across, across) > 0)) return side.ns;
  const Vec3f t = normalize(across);
  // Tangents wind with the object; a mirroring transform turns n x t around.
  const bool behind = is_behind(instance, triangle, -side.ng);
  const Vec3f n = behind ? -side.ns : side.ns;
  const Vec3f b = cross(n, t) * ((tangent.w < 0) != mirrors(placement) ? -1.0f : 1.0f);
  const Rgb m = map.color(instance.primvars_at(triangle, side.uv));
  const Vec3f mapped = t * m.r + b * m.g + n * m.b;
  const float l2 = dot(mapped, mapped);
  if (!(l2 > 0) || !std::isfinite(l2)) return side.ns;
  return mapped * ((behind ? -1.0f : 1.0f) / std::sqrt(l2));
}

bool winds_clockwise(const Instance& instance, const Placement& placement, const TriangleHit& triangle,
                     const SurfaceHit& side) {
  const bool mirrored = has_mirrored_uvs(instance.prototype->mesh, triangle.triangle) != mirrors(placement);
  return mirrored != is_behind(instance, triangle, -side.ng);
}

Vec3f reflecting_normal(const Vec3f& n, const Vec3f& surface, const Vec3f& wo) {
  const float view = dot(surface, wo);
  const Vec3f mirrored = n * (2 * dot(n, wo)) - wo;
  // At a silhouette the mirror image may lie as low as the viewer does.
  const float least = std::min(0.9f * view, 0.01f), height = dot(mirrored, surface);
  if (height >= least) return n;
  const Vec3f half = wo + normalize(mirrored + surface * (least - height));
  const float l2 = dot(half, half);
  return l2 > 0 ? half * (1 / std::sqrt(l2)) : surface;
}

}  // namespace alabaster
