#include "core/subsurface/body.h"

#include <gtest/gtest.h>

#include "testenv/support/scene_builder.h"

namespace alabaster {
namespace {

using testing::SceneBuilder;
using testing::sphere_mesh;

const Vec3f kAside = Vec3f(0.3f, 0.5f, 0.8f);

Matrix4d placed(double x, double scale = 1) {
  return Matrix4d().setScale(scale) * Matrix4d().setTranslation(Vec3d(x, 0, 0));
}

Mesh turned_inside_out(Mesh mesh) {
  for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

// Too many sheets through the whole of it for a distance grid.
Mesh heap_of_sheets() {
  Mesh mesh;
  mesh.points = {{-1, -1, -1}, {1, 1, -1}, {-1, 1, 1}};
  mesh.triangles.assign(2000, {0, 1, 2});
  for (const Vec3f& p : mesh.points) mesh.bounds.extend(p);
  return mesh;
}

// Meshes that scatter as one body, or alone if there is one only.
class Bodies {
 public:
  explicit Bodies(float scatter_distance = 0.01f) {
    DisneyParameters wax;
    wax.scatter_distance = Rgb(scatter_distance);
    wax_ = builder_.material(wax);
  }
  Bodies& add(const std::shared_ptr<const MeshPrototype>& prototype, const Matrix4d& to_world = Matrix4d()) {
    builder_.add(prototype, wax_, to_world);
    return *this;
  }
  Bodies& add(Mesh mesh, const Matrix4d& to_world = Matrix4d()) {
    return add(builder_.prototype(std::move(mesh)), to_world);
  }
  const SubsurfaceBody& body() {
    auto& instances = builder_.description.instances;
    if (instances.size() > 1)
      for (InstanceDescription& d : instances) d.subsurface_set = "one";
    snapshot_ = builder_.snapshot();
    return *snapshot_->instances[0].body;
  }
  /// World to render space; after body().
  Vec3f rendered(const Vec3d& world) const { return Vec3f(world - snapshot_->origin); }
  const SceneSnapshot& snapshot() const { return *snapshot_; }

 private:
  SceneBuilder builder_;
  std::shared_ptr<const DisneyMaterial> wax_;
  std::shared_ptr<const SceneSnapshot> snapshot_;
};

// At the middle of a triangle, from outside.
SubsurfaceEntry entry_of(const SceneSnapshot& scene, uint32_t instance, uint32_t triangle) {
  const Instance& i = scene.instances[instance];
  SubsurfaceEntry entry;
  entry.member = i.member;
  entry.triangle = {.t = 0, .u = 0.3f, .v = 0.3f, .triangle = triangle};
  entry.hit = surface_hit(i.prototype->mesh, entry.triangle, i.object_to_world, i.world_to_object);
  return entry;
}

TEST(SubsurfaceBody, LeavesALoneObjectOutwardsHoweverItIsWoundOrMirrored) {
  for (const Mesh& mesh : {sphere_mesh(1, 8, false), turned_inside_out(sphere_mesh(1, 8, false))})
    for (const double scale : {2.0, -2.0}) {
      Bodies b;
      const SubsurfaceBody& body = b.add(mesh, placed(7, scale)).body();
      ASSERT_FALSE(body.is_union());
      for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const Vec3f outward = entry_of(b.snapshot(), 0, t).hit.p - b.rendered({7, 0, 0});
        EXPECT_TRUE(body.leaves(0, {.triangle = t}, outward));
        EXPECT_FALSE(body.leaves(0, {.triangle = t}, -outward));
      }
    }
}

// Spheres about 0 and 1.5, the second turned inside out; and a plane that contains nothing.
TEST(SubsurfaceBody, AUnionContainsWhatAnyClosedShellDoes) {
  Bodies b;
  const Mesh sphere = sphere_mesh(1, 16, false);
  b.add(sphere).add(turned_inside_out(sphere), placed(1.5)).add(testing::plane_mesh(9));
  const SubsurfaceBody& body = b.body();
  const auto contained = [&](double x, double y) { return body.contains({b.rendered({x, y, 0.1}), kAside}); };
  EXPECT_TRUE(contained(-0.5, 0));
  EXPECT_TRUE(contained(0.75, 0)) << "in both";
  EXPECT_TRUE(contained(2, 0));
  EXPECT_FALSE(contained(0.75, 0.9)) << "between them, within the bounds";
  EXPECT_FALSE(contained(4, -0.1)) << "behind the plane";
  // Just left of the first sphere, all that counts is the second.
  const Vec3f inside = b.rendered({-0.5, 0, 0.1}) - body.origin;
  EXPECT_FALSE(body.contains_in_body_space({inside, kAside}, &body.members[0]));
}

TEST(SubsurfaceBody, AUnionOfManyContainsWhatAnyMemberDoes) {
  Bodies bodies;
  const auto ball = SceneBuilder().prototype(sphere_mesh(1, 24, false));
  Rng rng(5, 5);
  const auto random_place = [&] {
    const float x = rng.uniform(), y = rng.uniform();
    return Vec3d(x, y, rng.uniform()) * 10.0;
  };
  std::vector<Vec3d> centres;
  for (int i = 0; i < 200; ++i) {
    centres.push_back(random_place());
    bodies.add(ball, Matrix4d().setTranslation(centres.back()));
  }
  const SubsurfaceBody& body = bodies.body();
  ASSERT_TRUE(body.places) << "they are looked for in a tree";
  int inside = 0, outside = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3d p = random_place();
    double nearest = 100;
    for (const Vec3d& c : centres) nearest = std::min(nearest, length(c - p));
    if (std::abs(nearest - 0.985) < 0.02) continue;  // between the sphere and its facets
    EXPECT_EQ(body.contains({bodies.rendered(p), normalize(kAside)}), nearest < 1) << i;
    (nearest < 1 ? inside : outside)++;
  }
  EXPECT_GT(inside, 200);
  EXPECT_GT(outside, 200);
}

TEST(SubsurfaceBody, AUnionCrossesTheSurfaceThatWasHit) {
  Bodies b;
  const Mesh sphere = sphere_mesh(1, 16, false);
  const SubsurfaceBody& body = b.add(sphere).add(turned_inside_out(sphere), placed(3)).body();
  for (const double x : {0.0, 3.0}) {
    TriangleHit hit;
    const Vec3f from = b.rendered({x + 0.1, 0.2, 8}) - body.origin, direction(0, 0, -1);
    ASSERT_TRUE(body.scene->intersect({from, direction}, &hit));
    const Crossed in = body.cross(hit, direction);
    EXPECT_FALSE(in.leaves);
    EXPECT_TRUE(body.contains_in_body_space({in.beyond, direction}, nullptr));
    ASSERT_TRUE(body.scene->intersect({in.beyond, direction}, &hit));
    const Crossed out = body.cross(hit, direction);
    EXPECT_TRUE(out.leaves);
    EXPECT_FALSE(body.contains_in_body_space({out.beyond, direction}, nullptr));
  }
}

// A sphere step must keep clear of every member.
TEST(SubsurfaceBody, NoMemberHasAGridWhereOneCanHaveNone) {
  Bodies b;
  const SubsurfaceBody& body = b.add(sphere_mesh(1, 8, false)).add(heap_of_sheets()).body();
  EXPECT_TRUE(body.members[0].room_for_spheres);
  EXPECT_FALSE(body.bounds_distances());
  for (const SubsurfaceBody::Member& m : body.members) EXPECT_FALSE(m.distances);
}

}  // namespace
}  // namespace alabaster
