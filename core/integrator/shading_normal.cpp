#include "core/integrator/shading_normal.h"

namespace alabaster {

Vec3f mapped_normal(const Instance& instance, const TriangleHit& triangle, const SurfaceHit& side,
                    const TextureLookup& map) {
  const Mesh& mesh = instance.prototype->mesh;
  if (!instance.tangents) return side.ns;
  const Vec4f tangent = interpolated(*instance.tangents, mesh, triangle);
  const Affine& to_render = instance.object_to_world;
  const Vec3f along = to_render.vector({tangent.x, tangent.y, tangent.z});
  const Vec3f across = along - side.ns * dot(along, side.ns);
  if (!(dot(across, across) > 0)) return side.ns;
  const Vec3f t = normalize(across);
  // Tangents wind with the object; a mirroring transform turns n x t around.
  const bool behind = is_behind(instance, triangle.triangle, -side.ng);
  const bool mirrored = dot(cross(to_render.x, to_render.y), to_render.z) < 0;
  const Vec3f n = behind ? -side.ns : side.ns;
  const Vec3f b = cross(n, t) * ((tangent.w < 0) != mirrored ? -1.0f : 1.0f);
  const Rgb m = map.color(HitPrimvars(mesh, triangle, side.uv));
  const Vec3f mapped = t * m.r + b * m.g + n * m.b;
  const float l2 = dot(mapped, mapped);
  if (!(l2 > 0) || !std::isfinite(l2)) return side.ns;
  return mapped * ((behind ? -1.0f : 1.0f) / std::sqrt(l2));
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
