// A mesh as Embree holds it. Internal to this room.
#pragma once

#include "core/geometry/embree_handle.h"
#include "core/geometry/triangle_pairs.h"

namespace alabaster {

class EmbreeObjectScene final : public ObjectScene {
 public:
  enum class Use { traced, refitted };  // refitted: its points will be replaced
  EmbreeObjectScene(std::shared_ptr<TraceDevice> device, const Mesh& mesh, Use use = Use::traced)
      : scene_(std::move(device), "a hierarchy of triangles", use == Use::refitted),
        use_(use),
        quads_(are_pairs(mesh.triangles)),
        points_(mesh.points.size()),
        triangles_(mesh.triangles.size()),
        poses_(1 + mesh.later_poses.size()) {}

  /// Copies the mesh into buffers that Embree allocates (and pads: it reads 16 bytes at each 12-byte vertex). False:
  /// Embree refuses. Throws where memory runs out.
  bool attach(const Mesh& mesh);
  /// True if the mesh has these triangles of as many points, and none deforms.
  bool has_triangles_of(const Mesh& mesh) const;
  /// Takes the points of a mesh with the same triangles in the place of those it has, and keeps the hierarchy. Nobody
  /// may be tracing. It is to be committed.
  bool replace_points(const Mesh& mesh);

  bool intersect(const Ray& ray, TriangleHit* hit) const override;
  void intersect_all(const Ray& ray, std::pmr::vector<TriangleHit>* hits) const override;
  /// The coordinates of a hit at the first corner, which Embree answers where a triangle is very small. `to_world`
  /// carries the mesh to the ray's space. A mesh that deforms is left as it is.
  void mend(const Affine& to_world, const Ray& ray, TriangleHit* hit) const;

  size_t memory_bytes() const override {
    // The buffers are known; the hierarchy takes about 66 bytes a triangle, 36 where two are a quad, and at most 200
    // where it deforms (Embree does not tell per scene).
    const size_t hierarchy_per_triangle = poses_ > 1 ? 200 : quads_ ? 36 : 66;
    const size_t corners_per_triangle = quads_ ? 2 : 3;
    return poses_ * points_ * sizeof(Vec3f) +
           triangles_ * (corners_per_triangle * sizeof(uint32_t) + hierarchy_per_triangle);
  }
  RTCScene get() const { return scene_.get(); }
  bool take_error() const { return scene_.take_error(); }

 private:
  RTCGeometry geometry() const;
  const void* indices() const;
  Corners corners(const void* indices, size_t triangle) const;

  SceneHandle scene_;
  Use use_;
  bool quads_;  // its triangles are in pairs
  size_t points_, triangles_, poses_;
};

}  // namespace alabaster
