// Nodes above a surface: what becomes a constant, what a texture, and what is told.
#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

#include "core/texture/uv_transform.h"
#include "delegate/looks/looks.h"
#include "testenv/support/stage.h"

namespace alabaster::hd::looks {
namespace {

using Parameters = std::map<Token, Value>;
using Connections = std::map<Token, std::vector<MaterialConnection>>;

/// An OpenPBR surface; nodes are named by a letter.
struct SampleLook {
  SampleLook() {
    network.nodes["/s"] = {"ND_open_pbr_surface_surfaceshader", {}, {}};
    network.terminals["surface"] = {"/s", "out"};
  }
  void add(const char* name, const char* type, Parameters parameters, const Connections& inputs = {}) {
    network.nodes[name] = {type, std::move(parameters), inputs};
  }
  void add_image(const char* name, const char* type = "ND_image_color3", Parameters parameters = {}) {
    parameters["file"] = AssetPath{"a.png", "/a.png", nullptr};
    add(name, type, std::move(parameters));
  }
  void connect(const char* input, const char* node, const char* output = "out") {
    network.nodes["/s"].inputConnections[input] = {{node, output}};
  }
  const MaterialNode& read() {
    warnings.clear();
    result = ReadLook(network, [&](const char*, const std::string& text) { warnings.push_back(text); });
    return result.nodes.at("/s");
  }
  /// The texture that a parameter is connected to.
  const MaterialNode& texture(const char* parameter) {
    return result.nodes.at(result.nodes.at("/s").inputConnections.at(parameter).at(0).upstreamNode);
  }
  MaterialNetwork network, result;
  std::vector<std::string> warnings;
};

MaterialConnection from(const char* node, const char* output = "out") {
  return {node, output};
}

TEST(Coats, WhatIsBelowOneFollowsItOrIsToldOnce) {
  SampleLook look;
  look.network.nodes["/s"].parameters = {
      {"coat_weight", 1.0f}, {"coat_roughness", 0.5f}, {"specular_roughness", 0.0f}, {"emission_luminance", 2.0f}};
  look.add_image("/t");
  look.connect("coat_color", "/t");
  EXPECT_EQ(look.read().parameters.at("roughness"), Value(std::pow(0.125f, 0.25f)));
  EXPECT_EQ(look.texture("emission"), look.texture("coatColor"));
  EXPECT_TRUE(look.warnings.empty());
  look.add_image("/r", "ND_image_float");
  look.connect("specular_roughness", "/r"), look.connect("coat_weight", "/r");
  look.read();
  ASSERT_EQ(look.warnings.size(), 1u);
  EXPECT_NE(look.warnings[0].find("a coat does not change"), std::string::npos) << look.warnings[0];
}

TEST(Patterns, ConstantsAreFolded) {
  SampleLook look;
  look.add("/c", "ND_constant_color3", {{"value", Vec3f(0.1f, 0.2f, 0.4f)}});
  look.add("/m", "ND_multiply_color3FA", {{"in2", 2.0f}}, {{"in1", {from("/c")}}});
  look.add("/i", "ND_invert_color3", {}, {{"in", {from("/m")}}});
  look.add("/x", "ND_mix_color3", {{"fg", Vec3f(1)}, {"mix", 0.5f}}, {{"bg", {from("/i")}}});
  look.add("/p", "ND_power_color3FA", {{"in2", 2.0f}}, {{"in1", {from("/x")}}});
  look.add("/e", "ND_extract_color3", {{"index", 2}}, {{"in", {from("/p")}}});
  look.connect("base_color", "/p");
  look.connect("specular_roughness", "/e");
  const MaterialNode& surface = look.read();
  EXPECT_TRUE(look.warnings.empty());
  const Vec3f color = surface.parameters.at("baseColor").get_or(Vec3f(0));
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(color[i], std::pow(1 - std::vector{0.1, 0.2, 0.4}[size_t(i)], 2), 1e-6);
  EXPECT_NEAR(surface.parameters.at("roughness").number_or(0), 0.36, 1e-6);
}

TEST(Patterns, ArithmeticOfOneImageIsItsScaleAndBias) {
  SampleLook look;
  look.add_image("/t");
  look.add("/m", "ND_multiply_color3", {{"in2", Vec3f(0.5f, 0.25f, 1)}}, {{"in1", {from("/t")}}});
  look.add("/a", "ND_add_color3FA", {{"in2", 0.1f}}, {{"in1", {from("/m")}}});
  look.add("/x", "ND_mix_color3", {{"fg", Vec3f(1)}, {"mix", 0.5f}}, {{"bg", {from("/a")}}});
  look.add("/i", "ND_invert_color3", {}, {{"in", {from("/x")}}});
  look.connect("base_color", "/i");
  look.read();
  EXPECT_TRUE(look.warnings.empty());
  // 1 - ((texel k + .1) / 2 + 1 / 2)
  const Vec4f scale = look.texture("baseColor").parameters.at("scale").get_or(Vec4f(0));
  const Vec4f bias = look.texture("baseColor").parameters.at("bias").get_or(Vec4f(0));
  EXPECT_NEAR(scale.x, -0.25, 1e-6);
  EXPECT_NEAR(scale.y, -0.125, 1e-6);
  EXPECT_NEAR(bias.x, 0.45, 1e-6);
  EXPECT_EQ(look.texture("baseColor").parameters.at("sourceColorSpace").text_or(""), "raw") << "none is given";
}

TEST(Patterns, ProductsOfImagesStayProducts) {
  SampleLook look;
  look.add_image("/t");
  look.add_image("/u", "ND_image_float");
  look.add("/m", "ND_multiply_color3FA", {}, {{"in1", {from("/t")}}, {"in2", {from("/u")}}});
  look.connect("base_color", "/m");
  look.network.nodes["/s"].parameters["base_weight"] = 0.5f;
  const MaterialNode& surface = look.read();
  EXPECT_EQ(surface.inputConnections.at("baseColor"), (std::vector<MaterialConnection>{{"/t", "rgb"}, {"/u", "r"}}));
  EXPECT_EQ(surface.parameters.at("baseColor"), Value(Vec3f(0.5f)));
  EXPECT_TRUE(look.warnings.empty());
}

TEST(Patterns, ChannelsThatArePutTogetherAgainAreTheImage) {
  SampleLook look;
  look.add_image("/t");
  look.add("/s3", "ND_separate3_color3", {}, {{"in", {from("/t")}}});
  look.add("/c", "ND_combine3_color3", {},
           {{"in1", {from("/s3", "outr")}}, {"in2", {from("/s3", "outg")}}, {"in3", {from("/s3", "outb")}}});
  look.connect("base_color", "/c");
  look.connect("base_metalness", "/s3", "outb");
  const MaterialNode& surface = look.read();
  EXPECT_EQ(surface.inputConnections.at("baseColor").at(0), (MaterialConnection{"/t", "rgb"}));
  EXPECT_EQ(surface.inputConnections.at("metallic").at(0), (MaterialConnection{"/t", "b"}));
  look.network.nodes["/c"].inputConnections["in2"] = {from("/s3", "outb")};
  look.read();
  EXPECT_EQ(look.warnings.size(), 1u);
}

TEST(Patterns, OtherNodesAreNamedAndLeaveTheConstant) {
  SampleLook look;
  look.add_image("/t");
  look.add("/n", "ND_noise3d_color3", {});
  look.add("/m", "ND_multiply_color3", {}, {{"in1", {from("/t")}}, {"in2", {from("/n")}}});
  look.add("/a", "ND_add_color3", {}, {{"in1", {from("/t")}}, {"in2", {from("/t")}}});
  look.connect("base_color", "/m");
  look.connect("specular_color", "/a");
  look.network.nodes["/s"].parameters["base_color"] = Vec3f(0.3f);
  EXPECT_EQ(look.read().parameters.at("baseColor"), Value(Vec3f(0.3f)));
  ASSERT_EQ(look.warnings.size(), 2u);
  EXPECT_NE(look.warnings[0].find("ND_noise3d_color3"), std::string::npos) << look.warnings[0];
  EXPECT_NE(look.warnings[1].find("ND_add_color3"), std::string::npos) << look.warnings[1];
}

// Each node twice the other: as many paths as there are grains of sand.
TEST(Patterns, NetworksThatMultiplyWithoutEndAreRefusedAtOnce) {
  SampleLook look;
  look.add_image("/0");
  std::string below = "/0";
  for (int i = 1; i < 200; ++i) {
    const std::string name = "/" + std::to_string(i);
    look.add(name.c_str(), "ND_multiply_color3", {}, {{"in1", {from(below.c_str())}}, {"in2", {from(below.c_str())}}});
    below = name;
  }
  look.connect("base_color", below.c_str());
  look.read();
  EXPECT_EQ(look.warnings.size(), 1u);
}

TEST(Patterns, TexturesBelowTheSurfaceAreThoseOfTheirParameters) {
  SampleLook look;
  look.add_image("/t");
  look.add_image("/r");
  look.add_image("/w", "ND_image_float");
  auto& p = look.network.nodes["/s"].parameters;
  p["subsurface_weight"] = 1.0f, p["subsurface_color"] = Vec3f(0.8f), p["subsurface_radius"] = 2.0f;
  look.connect("subsurface_radius_scale", "/r");
  look.connect("subsurface_weight", "/w");
  look.connect("subsurface_color", "/t");
  const MaterialNode read = look.read();
  EXPECT_EQ(read.inputConnections.at("meanFreePath").at(0), (MaterialConnection{"/r", "rgb"}));
  EXPECT_EQ(read.parameters.at("meanFreePath").component(0), 2) << "times the texture";
  EXPECT_EQ(read.inputConnections.at("subsurfaceWeight").at(0), (MaterialConnection{"/w", "r"}));
  EXPECT_EQ(read.inputConnections.at("subsurfaceColor").at(0), (MaterialConnection{"/t", "rgb"}));
  EXPECT_TRUE(look.warnings.empty());
}

/// Where the image is read for coordinates uv.
Vec2f placed(const MaterialNode& texture, const Vec2f& uv) {
  const auto& p = texture.parameters;
  if (!p.contains("stScale")) return uv;
  return UvTransform(p.at("stOffset").get_or(Vec2f(0)), float(p.at("stRotation").number_or(0)),
                     p.at("stScale").get_or(Vec2f(0)))(uv);
}

TEST(Patterns, Place2dPlacesAsMaterialXDoes) {
  const Vec2f scale(2, 2), offset(0.1f, 0.3f), pivot(0.5f, 0.25f);
  for (const int order : {0, 1}) {
    SampleLook look;
    look.add_image("/t");
    look.add("/uv", "ND_texcoord_vector2", {{"index", 1}});
    look.add("/p", "ND_place2d_vector2",
             {{"scale", scale}, {"rotate", 30.0f}, {"offset", offset}, {"pivot", pivot}, {"operationorder", order}},
             {{"texcoord", {from("/uv")}}});
    look.network.nodes["/t"].inputConnections["texcoord"] = {from("/p")};
    look.connect("base_color", "/t");
    look.read();
    EXPECT_TRUE(look.warnings.empty());
    EXPECT_EQ(look.texture("baseColor").parameters.at("st").text_or(""), "st1");
    const double c = std::cos(M_PI / 6), s = std::sin(M_PI / 6);
    for (const Vec2f& uv : {Vec2f(0, 0), Vec2f(1, 0), Vec2f(0.3f, 0.7f)}) {
      Vec2d at(uv.x - pivot.x, uv.y - pivot.y);
      const auto turn = [&] { at = Vec2d(c * at.x + s * at.y, -s * at.x + c * at.y); };
      if (order == 0) at /= Vec2d(scale.x, scale.y), turn(), at -= Vec2d(offset.x, offset.y);
      if (order == 1) at -= Vec2d(offset.x, offset.y), turn(), at /= Vec2d(scale.x, scale.y);
      const Vec2f found = placed(look.texture("baseColor"), uv);
      EXPECT_NEAR(found.x, at.x + double(pivot.x), 1e-5) << order;
      EXPECT_NEAR(found.y, at.y + double(pivot.y), 1e-5) << order;
    }
  }
}

// MaterialX's glTF image is placed as KHR_texture_transform says, which is AlabasterTexture's own placement.
TEST(Patterns, GltfImagesArePlacedAsInGltf) {
  SampleLook look;
  look.add_image("/t", "ND_gltf_image_color3_color3_1_0",
                 {{"scale", Vec2f(2, 2)}, {"rotate", 40.0f}, {"offset", Vec2f(0.2f, 0.3f)}, {"factor", Vec3f(0.5f)}});
  look.connect("base_color", "/t");
  EXPECT_EQ(look.read().parameters.at("baseColor"), Value(Vec3f(0.5f)));
  const UvTransform khr({0.2f, 0.3f}, 40 * float(M_PI) / 180, {2, 2});
  for (const Vec2f& uv : {Vec2f(0, 0), Vec2f(1, 0), Vec2f(0.3f, 0.7f)}) {
    const Vec2f found = placed(look.texture("baseColor"), uv), expected = khr(uv);
    EXPECT_NEAR(found.x, expected.x, 1e-5);
    EXPECT_NEAR(found.y, expected.y, 1e-5);
  }
}

// MaterialX: (uv tiling - offset) / realworldimagesize * realworldtilesize.
TEST(Patterns, TilesHaveTheirSizeInTheWorld) {
  SampleLook look;
  look.add_image("/t", "ND_tiledimage_color3",
                 {{"uvtiling", Vec2f(3, 2)},
                  {"uvoffset", Vec2f(0.5f, 0.25f)},
                  {"realworldimagesize", Vec2f(2, 4)},
                  {"realworldtilesize", Vec2f(0.5f, 3)}});
  look.connect("base_color", "/t");
  look.read();
  EXPECT_TRUE(look.warnings.empty());
  for (const Vec2f& uv : {Vec2f(0, 0), Vec2f(1, 0), Vec2f(0.3f, 0.7f)}) {
    const Vec2f found = placed(look.texture("baseColor"), uv);
    EXPECT_NEAR(found.x, (uv.x * 3 - 0.5f) / 2 * 0.5f, 1e-5);
    EXPECT_NEAR(found.y, (uv.y * 2 - 0.25f) / 4 * 3, 1e-5);
  }
}

TEST(Patterns, AGltfColourImageIsMultipliedByBothColours) {
  SampleLook look;
  look.add_image("/t", "ND_gltf_colorimage",
                 {{"color", Vec4f(0.5f, 1, 1, 0.5f)}, {"geomcolor", Vec4f(0.5f, 0.25f, 1, 0.5f)}});
  look.connect("base_color", "/t", "outcolor");
  look.connect("geometry_opacity", "/t", "outa");
  EXPECT_EQ(look.read().parameters.at("baseColor"), Value(Vec3f(0.25f, 0.25f, 1)));
  EXPECT_EQ(look.read().parameters.at("opacity"), Value(0.25f));

  look.add("/g", "ND_geomcolor_color4", {});
  look.network.nodes["/t"].inputConnections["geomcolor"] = {from("/g")};
  const MaterialNode& surface = look.read();
  EXPECT_TRUE(look.warnings.empty());
  ASSERT_EQ(surface.inputConnections.at("baseColor").size(), 2u);
  EXPECT_EQ(surface.inputConnections.at("baseColor").at(1), (MaterialConnection{"displayColor", "rgb"}));
  EXPECT_EQ(surface.inputConnections.at("opacity").at(1), (MaterialConnection{"displayColor", "a"}));
  EXPECT_EQ(surface.parameters.at("baseColor"), Value(Vec3f(0.5f, 1, 1)));

  look.network.nodes["/t"].inputConnections["geomcolor"] = {from("/t", "outcolor")};
  look.read();
  EXPECT_EQ(look.warnings.size(), 2u) << "a circle";
}

// Arithmetic of one primvar is that of its numbers; the fallback goes through it, too.
TEST(Patterns, ReadersOfPrimvarsHaveTheirNameFallbackAndArithmetic) {
  SampleLook look;
  look.add("/p", "ND_geompropvalue_float", {{"geomprop", "wetness"}, {"default", 0.25f}});
  look.add("/dry", "ND_subtract_float", {{"in1", 1.0f}});
  look.network.nodes["/dry"].inputConnections["in2"] = {{"/p", "out"}};
  look.connect("specular_roughness", "/dry", "out");
  const auto& connection = look.read().inputConnections.at("roughness").front();
  EXPECT_TRUE(look.warnings.empty());
  EXPECT_EQ(connection.upstreamOutput, Token("r"));
  const MaterialNode& reader = look.texture("roughness");
  EXPECT_EQ(reader.nodeTypeId, Token("AlabasterPrimvar"));
  EXPECT_EQ(reader.parameters.at("varname"), Value(Token("wetness")));
  EXPECT_EQ(reader.parameters.at("scale"), Value(Vec4f(-1)));
  EXPECT_EQ(reader.parameters.at("bias"), Value(Vec4f(1)));
  EXPECT_EQ(reader.parameters.at("fallback"), Value(Vec4f(0.75f)));
}

TEST(Patterns, SpacesHaveOneNameForConstantsAndFiles) {
  // What .5 of red is, and what the file's reader is told.
  const std::tuple<const char*, double, const char*> spaces[] = {
      {"lin_rec709_scene", 0.5, "linear"},
      {"srgb_rec709_scene", 0.21404, "auto"},
      {"g22_rec709_scene", std::pow(0.5, 2.2), "g22_rec709"},
      {"lin_ap1_scene", 0.5 * 1.70505, "acescg"},
      {"lin_p3d65_scene", 0.5 * 1.22493, "lin_displayp3"},
  };
  for (const auto& [space, red, name] : spaces) {
    SampleLook look;
    look.add_image("/t", "ND_image_color3", {{"colorSpace:file", Token(space)}});
    look.connect("specular_color", "/t");
    auto& p = look.network.nodes["/s"].parameters;
    p["base_color"] = Vec3f(0.5f, 0, 0), p["colorSpace:base_color"] = Token(space);
    EXPECT_NEAR(look.read().parameters.at("baseColor").component(0), red, 1e-3) << space;
    EXPECT_EQ(look.texture("specularColor").parameters.at("sourceColorSpace").text_or(""), name);
    EXPECT_TRUE(look.warnings.empty());
  }
}

TEST(Patterns, ConstantsOfOtherSpacesBecomeRec709) {
  SampleLook look;
  auto& p = look.network.nodes["/s"].parameters;
  p["base_color"] = Vec3f(0.5f), p["colorSpace:base_color"] = Token("srgb_texture");
  EXPECT_NEAR(look.read().parameters.at("baseColor").component(0), 0.21404, 1e-5);
  EXPECT_EQ(look.result.nodes["/s"].parameters.at("baseColor:colorSpace"), Value(Token("lin_rec709")));
  // ACEScg's green in Rec. 709, by the published matrix.
  p["base_color"] = Vec3f(0, 1, 0), p["colorSpace:base_color"] = Token("acescg");
  const Value green = look.read().parameters.at("baseColor");
  EXPECT_NEAR(green.component(0), -0.62179, 2e-3);
  EXPECT_NEAR(green.component(1), 1.1408, 2e-3);
  EXPECT_TRUE(look.warnings.empty());
  p["colorSpace:base_color"] = Token("studio_paint");
  look.read();
  EXPECT_EQ(look.warnings.size(), 1u);
}

TEST(Patterns, DisplacementsOfMaterialXAreTextures) {
  SampleLook look;
  look.add_image("/t", "ND_image_float");
  look.add("/d", "ND_displacement_float", {{"scale", 0.25f}}, {{"displacement", {from("/t")}}});
  look.network.terminals["displacement"] = {"/d", "out"};
  look.read();
  EXPECT_TRUE(look.warnings.empty());
  const MaterialNode& node = look.result.nodes.at(look.result.terminals.at("displacement").upstreamNode);
  EXPECT_EQ(node.parameters.at("scale"), Value(0.25f));
  EXPECT_EQ(node.inputConnections.at("displacement").at(0), (MaterialConnection{"/t", "r"}));
}

TEST(Patterns, AMissingImageIsItsFallbackWhereThatIsAuthored) {
  for (const bool authored : {false, true}) {
    Stage stage;
    stage.add_basic_scene();
    MaterialNetwork network;
    network.nodes["/m/s"] = {
        "UsdPreviewSurface", {}, {{"diffuseColor", {{"/m/t", "rgb"}}}, {"roughness", {{"/m/t", "g"}}}}};
    network.nodes["/m/t"] = {"UsdUVTexture", {{"file", AssetPath{"gone.png", "/gone.png", nullptr}}}, {}};
    if (authored) network.nodes["/m/t"].parameters["fallback"] = Vec4f(0.25f, 0.75f, 0.5f, 1);
    network.terminals["surface"] = {"/m/s", "surface"};
    stage.scene.SetMaterial("/m", network);
    auto quad = Stage::quad();
    quad.material = "/m";
    stage.scene.SetMesh("/quad", quad);
    const std::string dump = stage.dump();
    const bool shows = dump.find("baseColor (0.25, 0.75, 0.5)") != std::string::npos &&
                       dump.find("roughness 0.75") != std::string::npos;
    EXPECT_EQ(shows, authored) << dump;
    const auto found = stage.take_diagnostics();
    const bool is_fault =
        std::any_of(found.begin(), found.end(), [](const Diagnostic& d) { return d.severity == Severity::error; });
    EXPECT_EQ(is_fault, !authored);
    EXPECT_FALSE(found.empty());
  }
}

}  // namespace
}  // namespace alabaster::hd::looks
