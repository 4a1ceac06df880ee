// The surface at a hit: position, normals, tangent, texture coordinates, and the offset that a ray from there needs so
// as not to meet its own surface again.
#pragma once

#include "core/geometry/embree_scene.h"
#include "core/geometry/mesh.h"
#include "core/math/transform.h"

namespace alabaster {

/// Where on the surface, and how it lies: enough for light that leaves a body.
struct SurfacePoint {
  Vec3f p;           // render space, from the barycentric coordinates: on the triangle whatever the ray's length was
  Vec3f ng;          // unit, outward: the side from which the triangle winds counter-clockwise in object space
  Vec3f ns;          // unit shading normal, dot(ns, ng) >= 0
  float offset = 0;  // for offset_point(p, +-ng, offset), then traced in the scene of instances
  Vec3f p_object;    // object space
  Vec3f ng_object;   // unit
  float offset_object = 0;  // for offset_point(p_object, +-ng_object, offset_object), then traced in the ObjectScene
};

struct SurfaceHit : SurfacePoint {
  Vec3f dpdu;      // unit direction in which u grows; some direction perpendicular to ns when there are no uvs
  Vec2f uv{0, 0};  // v up
};

/// `hit` must come from tracing `mesh` under `object_to_render`; `render_to_object` is its inverse. Normals stay
/// outward under mirroring transforms. Degenerate triangles give some unit normal. Scaling all lengths by a power of
/// two scales the result exactly (no absolute epsilon).
SurfaceHit surface_hit(const Mesh& mesh, const TriangleHit& hit, const Affine& object_to_render,
                       const Affine& render_to_object);
/// The same without what textures need.
SurfacePoint surface_point(const Mesh& mesh, const TriangleHit& hit, const Affine& object_to_render,
                           const Affine& render_to_object);

/// True if texture coordinates tell a direction on the triangle.
bool has_direction_of_u(const Mesh& mesh, uint32_t triangle);
/// The unit tangent that stands in for it: about the y axis of the object's space, so that it turns with the object;
/// along x where the surface lies across that axis.
Vec3f stand_in_tangent(const SurfacePoint& at, const Affine& object_to_render);

/// True if v grows clockwise from u, seen from where the triangle winds counter-clockwise, in the mesh's first set.
bool has_mirrored_uvs(const Mesh& mesh, uint32_t triangle);

/// The attribute's indices for a triangle.
template <class T>
const Corners& corners_of(const MeshAttribute<T>& attribute, const Mesh& mesh, uint32_t triangle) {
  return attribute.triangles.empty() ? mesh.triangles[triangle] : attribute.triangles[triangle];
}

template <class T>
T interpolated(const MeshAttribute<T>& attribute, const Mesh& mesh, const TriangleHit& hit) {
  const Corners& c = corners_of(attribute, mesh, hit.triangle);
  const std::vector<T>& v = attribute.values;
  return v[c[0]] * (1 - hit.u - hit.v) + v[c[1]] * hit.u + v[c[2]] * hit.v;
}

/// The part of a surface that textures may be read as means over.
struct SurfaceFootprint {
  float width = 0;                           // render space; 0: a point
  const Affine* object_to_render = nullptr;  // needed for a width
};

/// Primvars by instance, in the place of those of its mesh. Immutable; any thread.
class InstanceValues {
 public:
  virtual ~InstanceValues() = default;
  virtual std::vector<UvSetName> names() const = 0;
  /// As HitPrimvars::read(); where there is none, *numbers stays as it is.
  virtual int read(const UvSetName& name, size_t instance, Vec4f* numbers) const = 0;
  /// True if all instances have the same in `other`, which is of the same kind. False may also mean not known.
  virtual bool are_alike(const InstanceValues& other) const = 0;
};
/// Null: the mesh's own are read.
struct InstanceOf {
  const InstanceValues* values = nullptr;
  size_t number = 0;
};

/// The primvars at a hit that textures read.
class HitPrimvars {
 public:
  /// `uv`: of the mesh's first set at the hit. Keeps references.
  HitPrimvars(const Mesh& mesh, const TriangleHit& hit, const Vec2f& uv, const SurfaceFootprint& footprint = {},
              const InstanceOf& instance = {})
      : mesh_(mesh), hit_(hit), uv_(uv), footprint_(footprint), instance_(instance) {}

  /// Render space; 0: textures are read at a point.
  float footprint() const { return footprint_.width; }
  /// With the footprint's map: how fast the set's uv change over the triangle, J J^T (xx, xy, yy) of the matrix J of uv
  /// per length in render space. 0 if the mesh has no such set.
  Vec3f uv_metric(const UvSetName& set) const;
  /// (0, 0) if the mesh has no such set.
  Vec2f uv(const UvSetName& set) const;
  /// The numbers of a primvar, and how many: 1 to 4, with 0 beyond them. 0: there is none of that name.
  int read(const UvSetName& name, Vec4f* numbers) const;

 private:
  int has_own(const UvSetName& name, Vec4f* numbers) const {
    return instance_.values ? instance_.values->read(name, instance_.number, numbers) : 0;
  }

  const Mesh& mesh_;
  const TriangleHit& hit_;
  Vec2f uv_;
  SurfaceFootprint footprint_;
  InstanceOf instance_;
};

/// Rays hit triangles in no order, so their memory is far away. These ask for it in two steps, of which the second
/// needs the first's answer: other work fits before each and before surface_hit().
inline void prefetch_triangle(const Mesh& mesh, uint32_t triangle) {
  const auto prefetch = [triangle](const auto& rows) {
    if (!rows.empty()) __builtin_prefetch(&rows[triangle]);
  };
  prefetch(mesh.triangles);
  prefetch(mesh.normal_triangles);
  if (!mesh.uv_sets.empty()) prefetch(mesh.uv_sets.front().triangles);
}
enum class Attributes { normals, normals_and_uvs };
void prefetch_corners(const Mesh& mesh, uint32_t triangle, Attributes attributes);

/// The distance, in render space, by which the curved surface that the vertex normals describe stands out from the flat
/// triangle at the hit, towards the side of `side` (of ng): zero for flat normals, and where the surface curves inward.
/// Light that leaves from there does not meet the facets beside it, which the shading normal knows nothing of (Hanika
/// 2021, "Hacking the Shadow Terminator", Ray Tracing Gems II, chapter 4).
Vec3f curvature_shift(const Mesh& mesh, const TriangleHit& hit, const SurfacePoint& side,
                      const Affine& object_to_render);

/// p moved by `offset` along unit n: a ray from there with tnear 0 into n's hemisphere does not meet the surface of p.
inline Vec3f offset_point(const Vec3f& p, const Vec3f& n, float offset) {
  return p + n * offset;
}

}  // namespace alabaster
