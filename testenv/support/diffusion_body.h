// A body that normalized diffusion spreads light over, and a point of it to enter at.
#pragma once

#include "core/geometry/surface_hit.h"
#include "core/subsurface/normalized_diffusion.h"
#include "testenv/support/mesh_bodies.h"
#include "testenv/support/scene_builder.h"

namespace alabaster::testing {

class DiffusionBody {
 public:
  explicit DiffusionBody(Mesh mesh, const Matrix4d& object_to_world = Matrix4d())
      : prototype_(SceneBuilder().prototype(std::move(mesh))),
        object_to_world_(to_affine(object_to_world)),
        world_to_object_(to_affine(object_to_world.inverse())) {}

  DiffusionSpace space() const { return {prototype_->object.get(), &prototype_->mesh, world_to_object_}; }
  const Mesh& mesh() const { return prototype_->mesh; }

  /// Where a ray from `eye` (world) first meets the body.
  DiffusionEntry entry(const Vec3f& eye, const Vec3f& direction, const Rgb& albedo, const Rgb& distance) const {
    DiffusionEntry e;
    prototype_->object->intersect({world_to_object_.point(eye), world_to_object_.vector(direction)}, &e.hit);
    const SurfaceHit s = surface_hit(prototype_->mesh, e.hit, object_to_world_, world_to_object_);
    const float side = dot(s.ng, direction) < 0 ? 1.0f : -1.0f;
    e.p_object = s.p_object, e.ng = s.ng * side, e.ng_object = s.ng_object * side, e.offset = s.offset;
    e.albedo = albedo, e.scatter_distance = distance;
    return e;
  }
  /// World.
  Vec3f position(const TriangleHit& hit) const {
    return surface_hit(prototype_->mesh, hit, object_to_world_, world_to_object_).p;
  }

 private:
  std::shared_ptr<const MeshPrototype> prototype_;
  Affine object_to_world_, world_to_object_;
};

inline std::optional<DiffusionExit> sample_exit(const DiffusionBody& body, const DiffusionEntry& entry, Rng& rng,
                                                RenderCounters& counters) {
  std::array<float, 4> u{};
  for (float& x : u) x = rng.uniform();
  return sample_diffusion_exit(body.space(), entry, u, rng, counters);
}

}  // namespace alabaster::testing
