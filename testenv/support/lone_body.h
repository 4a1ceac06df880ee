// Bodies of one object and points of their surface, as the input of carriers of light in tests.
#pragma once

#include "core/subsurface/body.h"
#include "testenv/support/mesh_bodies.h"
#include "testenv/support/scene_builder.h"

namespace alabaster::testing {

/// `mesh` may be empty where `object` is no mesh. Both must outlive the body. No shortcut is planned.
inline SubsurfaceBody lone_body(const ObjectScene& object, const Mesh& mesh, const Affine& to_object = {}) {
  static const MeshShells kClosedAndOutward;
  SubsurfaceBody body;
  body.members.emplace_back();
  SubsurfaceBody::Member& member = body.members.front();
  member.mesh = &mesh;
  member.object = &object;
  member.shells = &kClosedAndOutward;
  member.to_object = to_object;
  body.bounds = mesh.bounds;
  return body;
}

/// An entry exactly at `p` (object space), where `outward` is every normal. `medium` must outlive the entry.
inline SubsurfaceEntry entry_at_point(const Vec3f& p, const Vec3f& outward, const WalkMedium& medium) {
  SubsurfaceEntry entry;
  entry.hit.p_object = p;
  entry.hit.ng = entry.hit.ng_object = entry.ns = outward;
  entry.medium = &medium;
  return entry;
}

/// Carries light from an entry with fresh numbers, all from `rng`.
template <class Carrier>
std::optional<SubsurfaceExit> carry(const Carrier& carrier, const SubsurfaceBody& body, const SubsurfaceEntry& entry,
                                    Rng& rng, RenderCounters& counters) {
  SubsurfaceNumbers numbers(rng);
  const auto exit = carrier.carry(body, entry, numbers, counters);
  rng = numbers.rng();
  return exit;
}

/// A mesh in the world, as a body, and where rays meet it.
class BodyInWorld {
 public:
  explicit BodyInWorld(Mesh mesh, const Matrix4d& object_to_world = Matrix4d())
      : prototype_(SceneBuilder().prototype(std::move(mesh))),
        object_to_world_(to_affine(object_to_world)),
        world_to_object_(to_affine(object_to_world.inverse())),
        body_(lone_body(*prototype_->object, prototype_->mesh, world_to_object_)) {
    body_.members.front().shells = &prototype_->shells();
    body_.members.front().to_body = object_to_world_;
  }
  BodyInWorld(const BodyInWorld&) = delete;
  BodyInWorld& operator=(const BodyInWorld&) = delete;

  const SubsurfaceBody& body() const { return body_; }
  const Mesh& mesh() const { return prototype_->mesh; }

  /// Where a ray from `eye` (world) first meets the body.
  SubsurfaceEntry entry(const Vec3f& eye, const Vec3f& direction, const WalkMedium& medium) const {
    TriangleHit triangle;
    prototype_->object->intersect({world_to_object_.point(eye), world_to_object_.vector(direction)}, &triangle);
    SubsurfaceEntry e = entry(triangle, medium);
    if (dot(e.hit.ng, direction) < 0) return e;
    e.hit.ng = -e.hit.ng, e.hit.ng_object = -e.hit.ng_object, e.ns = -e.ns;
    return e;
  }
  /// At a point of a triangle, on the side from which it winds counter-clockwise.
  SubsurfaceEntry entry(const TriangleHit& triangle, const WalkMedium& medium) const {
    SubsurfaceEntry e;
    e.triangle = triangle;
    e.hit = surface_hit(prototype_->mesh, triangle, object_to_world_, world_to_object_);
    e.ns = e.hit.ng;
    e.medium = &medium;
    return e;
  }
  /// World.
  Vec3f position(const TriangleHit& hit) const {
    return surface_hit(prototype_->mesh, hit, object_to_world_, world_to_object_).p;
  }

 private:
  std::shared_ptr<const MeshPrototype> prototype_;
  Affine object_to_world_, world_to_object_;
  SubsurfaceBody body_;
};

}  // namespace alabaster::testing
