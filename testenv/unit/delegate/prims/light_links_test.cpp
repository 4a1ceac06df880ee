// Light and shadow links through the contract: categories of meshes and of instances.
#include <gtest/gtest.h>

#include <array>
#include <sstream>

#include "testenv/support/stage.h"

namespace alabaster::hd {
namespace {

constexpr int kSize = 24;

// Small quads in a row, each in the category of its name.
class LinkedStage : public Stage {
 public:
  LinkedStage() : Stage({{"samples", int64_t(4)}, {"maxDepth", int64_t(1)}, {"threads", 2}}) {
    add_basic_scene();
    scene.Remove("/quad");
    scene.Remove("/dome");
    add_quad("/left", -1, {"left"});
    add_quad("/right", 1, {"right", "both"});
    add_sun("", "");
  }
  void add_quad(const char* path, double x, std::vector<Token> categories, const char* instancer = "") {
    host::MeshDescription mesh = quad();
    mesh.transform = Matrix4d().setScale(0.5);
    mesh.transform[3][0] = x;
    mesh.categories = std::move(categories);
    mesh.instancer = instancer;
    scene.SetMesh(path, mesh);
  }
  void add_sun(const char* light_link, const char* shadow_link) {
    host::LightDescription sun{.type = "distantLight", .transform = {}, .parameters = {{"angle", 0.0f}}};
    if (*light_link) sun.parameters["lightLink"] = light_link;
    if (*shadow_link) sun.parameters["shadowLink"] = std::string(shadow_link);
    scene.SetLight("/sun", sun);
  }
  /// The colours at x = -1, 0 and 1.
  std::array<float, 3> row() {
    RenderBuffer* buffer = add_buffer("/color", kSize, kSize, Format::float32vec4);
    index->SyncAll();
    const auto pass = delegate->CreateRenderPass();
    EXPECT_TRUE(finish(*pass, state_for(kSize, kSize, "color", buffer)));
    const auto rgba = pixels<float>(buffer);
    std::array<float, 3> colors;
    for (int i = 0; i < 3; ++i) colors[size_t(i)] = rgba[size_t(4 * (kSize / 2 * kSize + kSize / 4 * (i + 1)))];
    return colors;
  }
};

TEST(LightLinking, ALightLightsItsCategoryAndFollowsEdits) {
  LinkedStage stage;
  const auto all = stage.row();
  EXPECT_GT(all[0], 0);
  EXPECT_NEAR(all[0], all[2], 0.02);
  stage.add_sun("left", "");
  EXPECT_EQ(stage.row(), (std::array<float, 3>{all[0], 0, 0}));
  EXPECT_NE(stage.dump().find("  lightLink left\n"), std::string::npos);
  EXPECT_NE(stage.dump().find("  category left\n"), std::string::npos);
  stage.add_sun("both", "");
  EXPECT_EQ(stage.row(), (std::array<float, 3>{0, 0, all[2]}));
  stage.add_quad("/left", -1, {"both"});
  EXPECT_EQ(stage.row(), all);
  stage.add_sun("nobody", "");
  EXPECT_EQ(stage.row(), (std::array<float, 3>{0, 0, 0}));
  stage.add_sun("", "");
  EXPECT_EQ(stage.row(), all);
  EXPECT_TRUE(stage.take_diagnostics().empty());
}

TEST(LightLinking, ACategoryThatNoMeshHasIsReportedBesideASimilarOne) {
  LinkedStage stage;
  stage.add_sun("lefft", "right");
  stage.row();
  const std::vector<Diagnostic> heard = stage.take_diagnostics();
  ASSERT_EQ(heard.size(), 1u);
  EXPECT_EQ(heard[0].code + " " + heard[0].where + ": " + heard[0].text,
            "light.link /sun: lightLink names category 'lefft', which no mesh has; did you mean 'left'?");
}

TEST(LightLinking, NoMoreThanEightCategoriesAreComparedWithThoseThatMeshesHave) {
  LinkedStage stage;
  for (int i = 0; i < 24; ++i) {
    const std::string name = std::to_string(i / 2);
    host::LightDescription sun{.type = "distantLight", .transform = {}, .parameters = {}};
    sun.parameters["lightLink"] = "left" + std::string(name.size() == 1 ? "0" : "") + name;
    stage.scene.SetLight("/sun" + std::to_string(i), sun);
  }
  stage.index->SyncAll();
  EXPECT_EQ(stage.count("light.link"), 16u) << "two lights name each";
}

TEST(LightLinking, ShadowsAreCastByTheirCategory) {
  LinkedStage stage;
  const auto all = stage.row();
  host::MeshDescription roof = Stage::quad();  // over both, between them and the sun; the camera looks through it
  roof.transform = Matrix4d().setScale(2);
  roof.transform[3][2] = 1;
  roof.categories = {"roof"};
  stage.scene.SetMesh("/roof", roof);
  host::CameraDescription camera = stage.scene.GetCameras().at("/camera");
  camera.parameters["clippingRange"] = Vec2f(3.5f, 0);
  stage.scene.SetCamera("/camera", camera);
  EXPECT_EQ(stage.row(), (std::array<float, 3>{0, 0, 0}));
  stage.add_sun("", "roof");
  EXPECT_EQ(stage.row(), (std::array<float, 3>{0, 0, 0}));
  stage.add_sun("", "left");
  EXPECT_EQ(stage.row(), all);
  stage.add_sun("both", "left");
  EXPECT_EQ(stage.row(), (std::array<float, 3>{0, 0, all[2]}));
}

// Outer instances 0 and 1 of two inner ones each: the categories of all levels count.
TEST(LightLinking, InstancesHaveCategoriesOfTheirOwnAtEachLevel) {
  LinkedStage stage;
  stage.scene.Remove("/left");
  stage.scene.Remove("/right");
  stage.add_quad("/proto", 0, {"proto"}, "/inner");
  host::InstancerDescription inner, outer;
  inner.parent = "/outer";
  inner.primvars["hydra:instanceTranslations"] = Array<Vec3f>{{0, 0, 0}, {1, 0, 0}};
  inner.indices["/proto"] = {1, 0};
  inner.categories = {{"inner0"}, {"inner1", "left"}};
  outer.primvars["hydra:instanceTranslations"] = Array<Vec3f>{{0, -3, 0}, {0, 3, 0}};
  outer.indices["/inner"] = {0, 1};
  outer.categories = {{}, {"up"}};
  stage.scene.SetInstancer("/inner", inner);
  stage.scene.SetInstancer("/outer", outer);
  // The lines of the dump that name a category, by instance.
  const auto in_category = [&](const char* name) {
    stage.add_sun(name, "");
    std::string instances;
    std::istringstream lines(stage.dump());
    std::string current;
    for (std::string line; std::getline(lines, line);) {
      if (line.starts_with("instance ")) current = line.substr(line.rfind(' ') + 1);
      if (line.starts_with("  category ")) instances += current;
    }
    return instances;
  };
  EXPECT_EQ(in_category("proto"), "0123");
  EXPECT_EQ(in_category("inner0"), "13");
  EXPECT_EQ(in_category("inner1"), "02");
  EXPECT_EQ(in_category("up"), "23");
  outer.categories = {{"up"}};
  stage.scene.SetInstancer("/outer", outer);
  EXPECT_EQ(in_category("up"), "01");
  EXPECT_EQ(in_category(""), "");
}

}  // namespace
}  // namespace alabaster::hd
