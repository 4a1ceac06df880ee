// Every long stretch of a build asks its token.
#include <gtest/gtest.h>

#include <functional>

#include "core/light/light_image.h"
#include "core/material/displacement.h"
#include "core/scene/snapshot_compiler.h"
#include "testenv/support/cages.h"
#include "testenv/support/memory_texture.h"
#include "testenv/support/scene_builder.h"

namespace alabaster {
namespace {

TEST(Cancel, EveryBuildStepCanBeCancelledAndRepeated) {
  const auto device = make_trace_device({});
  const Cage cage = test::cube_cage(SubdivisionScheme::catmull_clark);
  RefinementOptions options;
  options.level = 4;
  const Mesh mesh = build_mesh(cage, options, {});
  const auto object = build_object_scene(device, mesh, {});
  const MeshInterior interior;
  const auto texture = std::make_shared<testing::MemoryTexture>(2, std::vector<Rgb>(4, Rgb(1.0f)));
  Displacements displacements(1);
  displacements[0] = Displacement{};
  displacements[0]->texture.image = texture;
  const std::pair<const char*, std::function<bool(const CancelToken&)>> stretches[] = {
      {"limit surface",
       [&](const CancelToken& cancel) {
         RefinementOptions cancelled = options;
         cancelled.cancel = cancel;
         return build_mesh(cage, cancelled, {}).triangles.size() == mesh.triangles.size();
       }},
      {"adaptive refinement",
       [&](const CancelToken& cancel) {
         RefinementOptions cancelled = options;
         cancelled.segments = [](const Vec3f&, const Vec3f&) { return 4.0f; };
         cancelled.cancel = cancel;
         return !build_mesh(cage, cancelled, {}).triangles.empty();
       }},
      {"closedness",
       [&](const CancelToken& cancel) {
         RefinementOptions cancelled;
         cancelled.cancel = cancel;
         return build_mesh(test::grid_cage(8), cancelled, {}).triangles.size() == 128;
       }},
      {"weld", [&](const CancelToken& cancel) { return !weld_by_position(mesh.points, cancel).empty(); }},
      {"displacement",
       [&](const CancelToken& cancel) {
         Mesh moved = mesh;
         displace(displacements, "mesh", {}, &moved, cancel);
         return true;
       }},
      {"shells", [&](const CancelToken& cancel) { return interior.shells(mesh, *object, cancel).any_closed; }},
      {"distance grid", [&](const CancelToken& cancel) { return interior.distances(mesh, cancel) != nullptr; }},
      {"image of a light",
       [&](const CancelToken& cancel) {
         return LightImage(texture, Rgb(1.0f), LightImage::Shape::lat_long, cancel).mean(Rgb(1.0f)).r == 1;
       }},
      {"density of an image",
       [&](const CancelToken& cancel) {
         return Distribution2D(std::vector<float>(4, 1.0f), 2, 2, cancel).memory_bytes() > 0;
       }},
      {"density of a mesh",
       [&](const CancelToken& cancel) { return Distribution1D(std::vector<float>(4, 1.0f), cancel).size() == 4; }}};
  for (const auto& [name, run] : stretches) {
    std::atomic<bool> flag{true};
    EXPECT_THROW(run(CancelToken(&flag)), BuildCancelled) << name;
    flag = false;
    EXPECT_TRUE(run(CancelToken(&flag))) << name;
  }
}

TEST(Cancel, TopLevelsAreCancelled) {
  const auto device = make_trace_device({});
  const auto object = build_object_scene(device, testing::sphere_mesh(1, 8, true), {});
  const std::vector<InstancePlacement> placements(2000, {object, Affine()});
  int asked = 0;
  EXPECT_EQ(build_instanced_scene(device, placements, [&] { return ++asked > 1; }), nullptr) << "while they are placed";
  EXPECT_NE(build_instanced_scene(device, placements, [] { return false; }), nullptr);
}

TEST(Cancel, ACancelledSnapshotLeavesTheNextOneAllThatItShares) {
  testing::SceneBuilder b;
  DisneyParameters wax;
  wax.scatter_distance = Rgb(0.1f);
  b.add(b.prototype(testing::sphere_mesh(1, 8, true)), b.material(wax)).add(testing::constant_dome(1, false));
  SnapshotCompiler compiler(make_trace_device({}), {});
  const auto first = compiler.compile(b.description, 1);
  std::atomic<bool> flag{true};
  EXPECT_THROW(compiler.compile(b.description, 2, CancelToken(&flag)), BuildCancelled);
  EXPECT_EQ(compiler.compile(b.description, 2)->top, first->top);
}

}  // namespace
}  // namespace alabaster
