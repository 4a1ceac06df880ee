// Picks: from a rectangle of the picture to prims, instances and faces.
#include "delegate/host/picker.h"

#include <gtest/gtest.h>

#include "testenv/support/stage.h"

namespace alabaster::hd::host {
namespace {

constexpr int kSide = 16;  // pixels of a quarter unit

class Picker : public ::testing::Test {
 protected:
  Picker() : stage({{"samples", int64_t(1)}, {"filter", std::string("box")}}) {
    stage.add_basic_scene();
    stage.scene.Remove("/quad");
    pass = stage.delegate->CreateRenderPass();
    state = Stage::state_for(kSide, kSide, "primId", stage.add_buffer("/ids", kSide, kSide, Format::int32));
    state.aovBindings.push_back({"instanceId", stage.add_buffer("/numbers", kSide, kSide, Format::int32), {}});
    state.aovBindings.push_back({"elementId", stage.add_buffer("/faces", kSide, kSide, Format::int32), {}});
  }
  ~Picker() override { pass.reset(); }

  static MeshDescription square(double x, double y, double size) {
    MeshDescription mesh = Stage::quad();
    mesh.transform.setScale(Vec3d(size / 2));
    mesh.transform[3][0] = x, mesh.transform[3][1] = y;
    return mesh;
  }
  std::vector<PickHit> pick(const Rect2i& rect) {
    stage.index->SyncAll();
    EXPECT_TRUE(Stage::finish(*pass, state));
    return Pick(*stage.index, stage.scene, state, rect);
  }
  static Rect2i pixel(double x, double y) {
    const int column = static_cast<int>((x + 2) * 4), row = static_cast<int>((2 - y) * 4);
    return {column, row, column + 1, row + 1};
  }
  static Matrix4d moved(double x, double y) {
    Matrix4d m;
    m.setTranslation(Vec3d(x, y, 0));
    return m;
  }

  Stage stage;
  std::unique_ptr<RenderPass> pass;
  RenderPassState state;
};

// promise: embedding.pick
TEST_F(Picker, TheFaceUnderTheCursorComesFirst) {
  stage.scene.SetMesh("/left", square(-1, 0, 1));
  MeshDescription right = square(1, 0, 1);
  right.topology.faceVertexCounts = {3, 3};
  right.topology.faceVertexIndices = {0, 1, 2, 0, 2, 3};  // below and above the diagonal
  stage.scene.SetMesh("/right", right);
  const auto below = pick(pixel(1.2, -0.3)), above = pick(pixel(0.8, 0.3));
  ASSERT_EQ(below.size(), 1u);
  EXPECT_EQ(below[0].path, Path("/right"));
  EXPECT_EQ(below[0].face, 0);
  EXPECT_TRUE(below[0].instances.empty());
  ASSERT_EQ(above.size(), 1u);
  EXPECT_EQ(above[0].face, 1);
  EXPECT_TRUE(pick(pixel(0, 1.5)).empty()) << "nothing is there";
  EXPECT_TRUE(pick({-100, -100, 0, 0}).empty()) << "outside of the picture";

  const Rect2i all = {0, 0, 8, kSide};  // whose middle is on the left square
  const auto found = pick(all);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].path, Path("/left"));
  EXPECT_LE(std::abs(found[0].x - 4), 1);
  EXPECT_LE(std::abs(found[0].y - 8), 1);
  EXPECT_EQ(pick({-5, -5, 1000, 1000}).size(), 3u) << "each face once";
}

// promise: embedding.pick
TEST_F(Picker, NestedInstancesAreListedFromTheInnermostOutwards) {
  // Two places of the outer one, three of the inner one. The numbers of points differ from those of instances.
  InstancerDescription outer, inner;
  outer.primvars["hydra:instanceTransforms"] = Array<Matrix4d>{moved(9, 9), moved(0, -1), moved(0, 1)};
  outer.indices["/inner"] = {2, 1};
  inner.parent = "/outer";
  inner.primvars["hydra:instanceTransforms"] = Array<Matrix4d>{moved(-1, 0), moved(0, 0), moved(1, 0), moved(9, 9)};
  inner.indices["/mesh"] = {2, 0, 1};
  stage.scene.SetInstancer("/outer", outer);
  stage.scene.SetInstancer("/inner", inner);
  MeshDescription mesh = square(0, 0, 0.5);
  mesh.instancer = "/inner";
  stage.scene.SetMesh("/mesh", mesh);
  for (const int column : {-1, 0, 1})
    for (const int row : {-1, 1}) {
      const auto hits = pick(pixel(column, row - 0.1));
      ASSERT_EQ(hits.size(), 1u) << column << row;
      const std::vector<PickedInstance> expected = {{"/inner", column + 1}, {"/outer", row < 0 ? 1 : 2}};
      EXPECT_EQ(hits[0].instances, expected) << column << row;
      const int inner_place = column == 1 ? 0 : column == -1 ? 1 : 2, outer_place = row == 1 ? 0 : 1;
      EXPECT_EQ(hits[0].instanceId, outer_place * 3 + inner_place);
    }
}

TEST_F(Picker, IdsThatAreNotBoundAreUnknown) {
  stage.scene.SetMesh("/left", square(-1, 0, 1));
  state.aovBindings.resize(1);
  const auto hits = pick(pixel(-1, 0));
  ASSERT_EQ(hits.size(), 1u);
  EXPECT_EQ(hits[0].face, -1);
  EXPECT_EQ(hits[0].instanceId, 0);
  state.aovBindings[0].aovName = "elementId";
  EXPECT_TRUE(pick(pixel(-1, 0)).empty());
}

}  // namespace
}  // namespace alabaster::hd::host
