#include "delegate/looks/looks.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/texture/uv_transform.h"

namespace alabaster::hd::looks {
namespace {

MaterialNetwork standard(std::map<Token, Value> parameters) {
  MaterialNetwork network;
  network.nodes["/m/s"] = {"ND_standard_surface_surfaceshader", std::move(parameters), {}};
  network.terminals["surface"] = {"/m/s", ""};
  return network;
}

struct StandardRead {
  explicit StandardRead(const MaterialNetwork& from) {
    network = ReadLook(from, [this](const char*, const std::string& text) { warnings.push_back(text); });
  }
  const MaterialNode& node(const char* path) const { return network.nodes.at(path); }
  const Value& parameter(const char* name) const { return node("/m/s").parameters.at(name); }
  Vec3f color(const char* name) const { return parameter(name).get_or(Vec3f(-1)); }
  bool has(const char* name) const { return node("/m/s").parameters.contains(name); }

  MaterialNetwork network;
  std::vector<std::string> warnings;
};

TEST(StandardSurface, HasItsOwnDefaults) {
  const StandardRead t(standard({}));
  EXPECT_EQ(t.node("/m/s").nodeTypeId, Token("AlabasterDisney"));
  EXPECT_EQ(t.parameter("roughness"), Value(0.2f));
  for (const char* name : {"baseColor", "ior", "meanFreePath", "coat", "sheen", "emission", "opacity", "iridescence"})
    EXPECT_FALSE(t.has(name)) << name;
  EXPECT_TRUE(t.warnings.empty());
}

TEST(OwnNodes, LoseNothingButEmptyColourSpaces) {
  MaterialNetwork network;
  network.nodes["/m/s"] = {
      "AlabasterDisney",
      {{"roughness", 0.3f}, {"colorSpace:roughness", Token("")}, {"colorSpace:baseColor", Token("srgb_texture")}},
      {}};
  network.nodes["/m/t"] = {"AlabasterTexture", {{"colorSpace:file", Token("")}}, {}};
  network.terminals["surface"] = {"/m/s", "surface"};
  const StandardRead t(network);
  network.nodes["/m/s"].parameters.erase("colorSpace:roughness");
  EXPECT_EQ(t.network, network);
  EXPECT_TRUE(t.warnings.empty());
}

TEST(StandardSurface, WeightsMultiplyTheirColours) {
  const StandardRead t(standard(
      {{"base", 0.5f}, {"base_color", Vec3f(1, 0.5f, 0)}, {"emission", 2.0f}, {"emission_color", Vec3f(1, 0, 0.5f)}}));
  EXPECT_EQ(t.color("baseColor"), Vec3f(0.5f, 0.25f, 0));
  EXPECT_EQ(t.color("emission"), Vec3f(2, 0, 1));
}

TEST(StandardSurface, TransmissionTintsTheSurfaceOrWithADepthTheInterior) {
  const StandardRead surface(standard({{"transmission", 1.0f}, {"transmission_color", Vec3f(1, 0.5f, 0)}}));
  EXPECT_EQ(surface.parameter("specTrans"), Value(1.0f));
  EXPECT_EQ(surface.color("baseColor"), Vec3f(1, 0.25f, 0)) << "of two crossings";
  const StandardRead interior(
      standard({{"transmission", 1.0f}, {"transmission_color", Vec3f(1, 0.5f, 0)}, {"transmission_depth", 2.0f}}));
  EXPECT_EQ(interior.color("attenuationColor"), Vec3f(1, 0.5f, 0));
  EXPECT_EQ(interior.parameter("attenuationDistance"), Value(2.0f));
  EXPECT_EQ(interior.color("baseColor"), Vec3f(1)) << "the surface takes nothing";
}

TEST(StandardSurface, LayersAreThereOnlyWithAWeight) {
  const StandardRead t(standard({{"coat", 0.5f},
                                 {"sheen", 0.25f},
                                 {"sheen_color", Vec3f(1, 0, 0)},
                                 {"thin_film_thickness", 300.0f},
                                 {"opacity", Vec3f(0.5f)}}));
  EXPECT_EQ(t.parameter("coat"), Value(0.5f));
  EXPECT_EQ(t.parameter("coatRoughness"), Value(0.1f));
  EXPECT_EQ(t.parameter("sheenTint"), Value(0.0f));
  EXPECT_EQ(t.color("sheenColor"), Vec3f(1, 0, 0));
  EXPECT_EQ(t.parameter("iridescenceThickness"), Value(300.0f));
  EXPECT_EQ(t.parameter("opacity"), Value(0.5f));
}

TEST(StandardSurface, UnsupportedInputsAreReported) {
  const StandardRead t(
      standard({{"diffuse_roughness", 0.5f}, {"coat", 1.0f}, {"coat_rotation", 0.2f}, {"coat_anisotropy", 0.5f}}));
  ASSERT_EQ(t.warnings.size(), 1u);
  EXPECT_NE(t.warnings[0].find("diffuse_roughness, coat_anisotropy, coat_rotation"), std::string::npos)
      << t.warnings[0];
  const StandardRead unused(standard({{"coat_affect_color", 1.0f}, {"transmission_dispersion", 3.0f}}));
  EXPECT_TRUE(unused.warnings.empty()) << "of layers that have no weight";
}

// An image of colours through a conversion, with its coordinates scaled, turned and moved.
MaterialNetwork textured_standard() {
  MaterialNetwork network = standard({{"base", 0.5f}});
  network.nodes["/m/uv"] = {"ND_geompropvalue_vector2", {{"geomprop", "map1"}}, {}};
  network.nodes["/m/1"] = {"ND_convert_vector2_vector3", {}, {{"in", {{"/m/uv", "out"}}}}};
  network.nodes["/m/2"] = {"ND_multiply_vector3", {{"in2", Vec3f(2, 3, 1)}}, {{"in1", {{"/m/1", "out"}}}}};
  network.nodes["/m/3"] = {
      "ND_rotate3d_vector3", {{"amount", 30.0f}, {"axis", Vec3f(0, 0, 1)}}, {{"in", {{"/m/2", "out"}}}}};
  network.nodes["/m/4"] = {"ND_add_vector3", {{"in2", Vec3f(0.25f, 0.5f, 0)}}, {{"in1", {{"/m/3", "out"}}}}};
  network.nodes["/m/5"] = {"ND_convert_vector3_vector2", {}, {{"in", {{"/m/4", "out"}}}}};
  network.nodes["/m/image"] = {"ND_image_color4",
                               {{"file", AssetPath{"a.png", "/a.png", nullptr}},
                                {"colorSpace:file", Token("srgb_texture")},
                                {"uaddressmode", "clamp"},
                                {"vaddressmode", "constant"},
                                {"filtertype", "closest"}},
                               {{"texcoord", {{"/m/5", "out"}}}}};
  network.nodes["/m/color"] = {"ND_convert_color4_color3", {}, {{"in", {{"/m/image", "out"}}}}};
  network.nodes["/m/alpha"] = {"ND_extract_color4", {{"index", 3}}, {{"in", {{"/m/image", "out"}}}}};
  auto& inputs = network.nodes["/m/s"].inputConnections;
  inputs["base_color"] = {{"/m/color", "out"}};
  inputs["opacity"] = {{"/m/alpha", "out"}};
  return network;
}

TEST(StandardSurface, ImagesAreTextures) {
  const StandardRead t(textured_standard());
  const MaterialNode& image = t.node("/m/image");
  EXPECT_EQ(image.nodeTypeId, Token("AlabasterTexture"));
  EXPECT_EQ(image.parameters.at("sourceColorSpace").text_or(""), "auto");
  EXPECT_EQ(image.parameters.at("wrapS").text_or(""), "clamp");
  EXPECT_EQ(image.parameters.at("wrapT").text_or(""), "black");
  EXPECT_EQ(image.parameters.at("filter").text_or(""), "nearest");
  EXPECT_EQ(image.parameters.at("st").text_or(""), "map1");
  const auto& inputs = t.node("/m/s").inputConnections;
  EXPECT_EQ(inputs.at("baseColor").front().upstreamOutput, Token("rgb"));
  EXPECT_EQ(inputs.at("opacity").front().upstreamOutput, Token("a"));
  EXPECT_EQ(t.color("baseColor"), Vec3f(0.5f)) << "base multiplies the image";
  EXPECT_TRUE(t.warnings.empty());
}

// MaterialX's rotate3d turns clockwise about z (its shader code of 1.38 and 1.39).
TEST(StandardSurface, CoordinatesAreScaledTurnedAndMoved) {
  const StandardRead t(textured_standard());
  const auto& placed = t.node("/m/image").parameters;
  const UvTransform ours(placed.at("stOffset").get_or(Vec2f(0)),
                         static_cast<float>(placed.at("stRotation").number_or(0)),
                         placed.at("stScale").get_or(Vec2f(0)));
  for (const Vec2f& uv : {Vec2f(0, 0), Vec2f(1, 0), Vec2f(0.3f, 0.7f)}) {
    const double x = 2 * double(uv.x), y = 3 * double(uv.y), c = std::cos(M_PI / 6), s = std::sin(M_PI / 6);
    const Vec2f expected(static_cast<float>(c * x + s * y + 0.25), static_cast<float>(-s * x + c * y + 0.5));
    const Vec2f found = ours(uv);
    EXPECT_NEAR(found.x, expected.x, 1e-5);
    EXPECT_NEAR(found.y, expected.y, 1e-5);
  }
}

TEST(StandardSurface, NormalMapsAreUnpacked) {
  MaterialNetwork network = standard({});
  network.nodes["/m/relief"] = {"ND_image_vector3", {{"file", AssetPath{"n.png", "/n.png", nullptr}}}, {}};
  network.nodes["/m/map"] = {"ND_normalmap", {{"scale", 0.5f}}, {{"in", {{"/m/relief", "out"}}}}};
  network.nodes["/m/s"].inputConnections["normal"] = {{"/m/map", "out"}};
  const StandardRead t(network);
  const auto& image = t.node(t.node("/m/s").inputConnections.at("normal").front().upstreamNode.str().c_str());
  EXPECT_EQ(image.parameters.at("scale"), Value(Vec4f(1, 1, 2, 1)));
  EXPECT_EQ(image.parameters.at("bias"), Value(Vec4f(-0.5f, -0.5f, -1, 0)));
  EXPECT_EQ(image.parameters.at("sourceColorSpace").text_or(""), "raw");
}

TEST(StandardSurface, ConnectionsThatCannotBeReadLeaveTheConstant) {
  MaterialNetwork network = standard({{"base_color", Vec3f(0.25f)}});
  network.nodes["/m/noise"] = {"ND_noise3d_color3", {}, {}};
  network.nodes["/m/a"] = {"ND_convert_color4_color3", {}, {{"in", {{"/m/a", "out"}}}}};  // a circle
  network.nodes["/m/s"].inputConnections["base_color"] = {{"/m/noise", "out"}};
  network.nodes["/m/s"].inputConnections["metalness"] = {{"/m/a", "out"}};
  network.nodes["/m/s"].inputConnections["specular"] = {{"/m/gone", "out"}};
  const StandardRead t(network);
  EXPECT_EQ(t.color("baseColor"), Vec3f(0.25f));
  EXPECT_EQ(t.warnings.size(), 3u);
  EXPECT_TRUE(t.node("/m/s").inputConnections.empty());
}

TEST(StandardSurface, AnOutputWithoutANameIsTheWholeImage) {
  MaterialNetwork network = textured_standard();
  network.nodes["/m/split"] = {"ND_separate4_color4", {}, {{"in", {{"/m/image", "out"}}}}};
  network.nodes["/m/s"].inputConnections["base_color"] = {{"/m/split", ""}};
  EXPECT_EQ(StandardRead(network).node("/m/s").inputConnections.at("baseColor").front().upstreamOutput, Token("rgb"));
}

TEST(Looks, OtherNetworksStayAsTheyAre) {
  MaterialNetwork network;
  network.nodes["/m/s"] = {"ND_surface", {{"roughness", 0.5f}}, {}};
  network.terminals["surface"] = {"/m/s", "surface"};
  EXPECT_EQ(StandardRead(network).network, network);
  EXPECT_EQ(StandardRead(MaterialNetwork()).network, MaterialNetwork());
}

}  // namespace
}  // namespace alabaster::hd::looks
