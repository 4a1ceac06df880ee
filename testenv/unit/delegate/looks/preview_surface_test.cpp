#include "delegate/looks/looks.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/texture/uv_transform.h"
#include "testenv/support/stage.h"

namespace alabaster::hd::looks {
namespace {

MaterialNetwork preview(std::map<Token, Value> parameters) {
  MaterialNetwork network;
  network.nodes["/m/surface"] = {"UsdPreviewSurface", std::move(parameters), {}};
  network.terminals["surface"] = {"/m/surface", "surface"};
  return network;
}

struct PreviewRead {
  explicit PreviewRead(const MaterialNetwork& from) {
    network =
        ReadLook(from, [this](const char* code, const std::string& text) { warnings.push_back(code + (": " + text)); });
  }
  const MaterialNode& node(const char* path) { return network.nodes.at(path); }
  const Value& parameter(const char* name) { return node("/m/surface").parameters.at(name); }

  MaterialNetwork network;
  std::vector<std::string> warnings;
};

TEST(PreviewSurface, HasTheSpecificationsDefaults) {
  PreviewRead t(preview({}));
  EXPECT_EQ(t.node("/m/surface").nodeTypeId, Token("AlabasterDisney"));
  EXPECT_EQ(t.parameter("baseColor"), Value(Vec3f(0.18f)));
  EXPECT_EQ(t.parameter("coatRoughness"), Value(0.01f));
  EXPECT_EQ(t.parameter("diffuseRoughness"), Value(0.43f));
  EXPECT_EQ(t.parameter("baseColor:colorSpace"), Value(Token("lin_rec709")));
  EXPECT_EQ(t.node("/m/surface").parameters.size(), 4u) << "the others are the same";
  EXPECT_TRUE(t.warnings.empty());
}

TEST(PreviewSurface, ConstantsAreParameters) {
  PreviewRead t(
      preview({{"diffuseColor", Vec3f(1, 0, 0)}, {"metallic", 1.0f}, {"clearcoat", 0.5f}, {"opacity", 0.3f}}));
  EXPECT_EQ(t.parameter("baseColor"), Value(Vec3f(1, 0, 0)));
  EXPECT_EQ(t.parameter("metallic"), Value(1.0f));
  EXPECT_EQ(t.parameter("coat"), Value(0.5f));
  EXPECT_EQ(t.parameter("opacity"), Value(0.3f));
}

TEST(PreviewSurface, OpacityIsTransparentUnlessItIsAskedForOtherwise) {
  const auto mode = [](const std::map<Token, Value>& parameters) {
    PreviewRead t(preview(parameters));
    EXPECT_TRUE(t.warnings.empty());
    const auto& all = t.node("/m/surface").parameters;
    return all.contains("opacityMode") ? all.at("opacityMode").text_or("") : "presence";
  };
  EXPECT_EQ(mode({{"opacity", 0.3f}}), "transparent");
  EXPECT_EQ(mode({{"opacity", 0.3f}, {"opacityMode", Token("transparent")}}), "transparent");
  EXPECT_EQ(mode({{"opacity", 0.3f}, {"opacityMode", Token("presence")}}), "presence");
  EXPECT_EQ(mode({{"opacity", 0.3f}, {"opacityThreshold", 0.2f}}), "presence");
  EXPECT_EQ(mode({}), "presence") << "an opaque surface is no sheet";
}

TEST(PreviewSurface, TheSpecularWorkflowGivesF0AndNoMetal) {
  PreviewRead t(preview({{"useSpecularWorkflow", 1}, {"specularColor", Vec3f(0.04f, 0.08f, 1)}, {"metallic", 1.0f}}));
  EXPECT_FALSE(t.node("/m/surface").parameters.contains("ior")) << "1.5";
  const Vec3f scale = t.parameter("specularColor").get_or(Vec3f(0));
  EXPECT_NEAR(scale.x, 1, 1e-6);
  EXPECT_NEAR(scale.y, 2, 1e-6);
  EXPECT_NEAR(scale.z, 25, 1e-5);
  EXPECT_FALSE(t.node("/m/surface").parameters.contains("metallic"));
}

// A texture with placed coordinates for colour and normal, and colours of the mesh.
MaterialNetwork textured_preview() {
  MaterialNetwork network = preview({{"diffuseColor", Vec3f(0.5f)}});
  network.nodes["/m/reader"] = {"UsdPrimvarReader_float2", {{"varname", "map1"}}, {}};
  network.nodes["/m/place"] = {"UsdTransform2d",
                               {{"rotation", 30.0f}, {"scale", Vec2f(2, 3)}, {"translation", Vec2f(0.25f, 0.5f)}},
                               {{"in", {{"/m/reader", "result"}}}}};
  network.nodes["/m/image"] = {"UsdUVTexture",
                               {{"file", "a.png"}, {"wrapS", "repeat"}, {"scale", Vec4f(2)}, {"bias", Vec4f(-1)}},
                               {{"st", {{"/m/place", "result"}}}}};
  network.nodes["/m/color"] = {"UsdPrimvarReader_float3", {{"varname", "displayColor"}}, {}};
  auto& inputs = network.nodes["/m/surface"].inputConnections;
  inputs["diffuseColor"] = {{"/m/color", "result"}};
  inputs["normal"] = {{"/m/image", "rgb"}};
  inputs["roughness"] = {{"/m/image", "g"}};
  inputs["displacement"] = {{"/m/image", "r"}};
  return network;
}

TEST(PreviewSurface, TexturesAndPrimvarsAreConnected) {
  PreviewRead t(textured_preview());
  const MaterialNode& surface = t.node("/m/surface");
  EXPECT_FALSE(surface.parameters.contains("baseColor")) << "a connection replaces the constant";
  const MaterialConnection& color = surface.inputConnections.at("baseColor").front();
  EXPECT_EQ(t.network.nodes.at(color.upstreamNode).nodeTypeId, Token("AlabasterPrimvar"));
  EXPECT_EQ(color.upstreamOutput, Token("rgb"));
  EXPECT_EQ(surface.inputConnections.at("normal").front(), (MaterialConnection{"/m/image", "rgb"}));
  EXPECT_EQ(surface.inputConnections.at("roughness").front(), (MaterialConnection{"/m/image", "g"}));
  EXPECT_EQ(t.node("/m/surface/displacement").inputConnections.at("displacement").front(),
            (MaterialConnection{"/m/image", "r"}));
  const MaterialNode& image = t.node("/m/image");
  EXPECT_EQ(image.nodeTypeId, Token("AlabasterTexture"));
  EXPECT_EQ(image.parameters.at("st"), Value("map1"));
  EXPECT_EQ(image.parameters.at("wrapS"), Value("repeat"));
  EXPECT_EQ(image.parameters.at("wrapT"), Value("black")) << "useMetadata";
  EXPECT_EQ(image.parameters.at("scale"), Value(Vec4f(2)));
  EXPECT_TRUE(t.warnings.empty());
}

// UsdTransform2d's definition, with v up: scale, then rotate counter-clockwise, then translate.
TEST(PreviewSurface, CoordinatesArePlacedAsSpecified) {
  PreviewRead t(textured_preview());
  const auto& parameters = t.node("/m/image").parameters;
  const UvTransform placed(parameters.at("stOffset").get_or(Vec2f(0)),
                           static_cast<float>(parameters.at("stRotation").number_or(0)),
                           parameters.at("stScale").get_or(Vec2f(0)));
  const double c = std::cos(std::numbers::pi / 6), s = std::sin(std::numbers::pi / 6);
  for (const Vec2f& uv : {Vec2f(0, 0), Vec2f(1, 0), Vec2f(0, 1), Vec2f(0.3f, 0.8f)}) {
    const double x = 2 * uv.x, y = 3 * uv.y;
    EXPECT_NEAR(placed(uv).x, c * x - s * y + 0.25, 1e-6);
    EXPECT_NEAR(placed(uv).y, s * x + c * y + 0.5, 1e-6);
  }
}

TEST(PreviewSurface, UnreadableInputsAreWarnedOfOnce) {
  MaterialNetwork network = preview({{"displacement", 0.1f}});
  network.nodes["/m/noise"] = {"UsdNoise", {}, {}};
  network.nodes["/m/reader"] = {"UsdPrimvarReader_string", {{"varname", "wetness"}}, {}};
  network.nodes["/m/image"] = {"UsdUVTexture", {}, {}};
  auto& inputs = network.nodes["/m/surface"].inputConnections;
  inputs["diffuseColor"] = {{"/m/noise", "out"}};
  inputs["roughness"] = {{"/m/reader", "result"}};
  inputs["metallic"] = {{"/m/image", "r"}};
  inputs["opacity"] = {{"/m/none", "r"}};
  PreviewRead t(network);
  EXPECT_EQ(t.warnings.size(), 5u);
  EXPECT_EQ(t.parameter("baseColor"), Value(Vec3f(0.18f)));
  EXPECT_TRUE(t.node("/m/surface").inputConnections.empty());
}

TEST(PreviewSurface, OtherNetworksStayAsTheyAre) {
  MaterialNetwork network = preview({});
  network.nodes["/m/surface"].nodeTypeId = "AlabasterDisney";
  EXPECT_EQ(PreviewRead(network).network, network);
  EXPECT_EQ(PreviewRead({}).network, MaterialNetwork());
}

TEST(PreviewSurface, IsDrawn) {
  Stage stage;
  stage.add_basic_scene();
  stage.scene.SetMaterial("/m", preview({{"diffuseColor", Vec3f(1, 0.5f, 0)}, {"roughness", 0.25f}}));
  auto quad = Stage::quad();
  quad.material = "/m";
  stage.scene.SetMesh("/quad", quad);
  const std::string dump = stage.dump();
  EXPECT_NE(dump.find("material /m"), std::string::npos) << dump;
  EXPECT_NE(dump.find("roughness 0.25"), std::string::npos) << dump;
  EXPECT_TRUE(stage.take_diagnostics().empty());
}

}  // namespace
}  // namespace alabaster::hd::looks
