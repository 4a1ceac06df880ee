#include "core/material/disney_material.h"

#include <gtest/gtest.h>

#include <limits>

#include "testenv/support/material_testing.h"
#include "testenv/support/memory_texture.h"

namespace alabaster {
namespace {

/// A gradient that counts how often it is read.
class CountingTexture : public Texture {
 public:
  Rgb rgb(const Vec2f& uv) const override {
    ++reads;
    return {uv.x, uv.y, 2};
  }
  int width() const override { return 1; }
  int height() const override { return 1; }
  size_t memory_bytes() const override { return 0; }
  Rgb texel(int, int) const override { return Rgb(1.0f); }
  mutable int reads = 0;
};

TEST(DisneyMaterial, ReadsATextureOnceForAllItsParameters) {
  const auto image = std::make_shared<CountingTexture>();
  DisneyMaterial material;
  material.constants.base_color = {0.5f, 0.25f, 0.8f};
  material.constants.metallic = 0.5f;
  testing::connect("baseColor", image, &material);
  for (const auto& [name, channel] : {std::pair("roughness", Channel::g), std::pair("metallic", Channel::r)})
    material.textures[0].uses.push_back({find_material_parameter(name), channel});
  const DisneyParameters p = testing::evaluate_at(material, {0.5f, 0.75f});
  EXPECT_EQ(image->reads, 1);
  EXPECT_EQ(p.base_color, Rgb(0.25f, 0.1875f, 1));  // the last channel clamped
  EXPECT_EQ(p.roughness, 0.375f);
  EXPECT_EQ(p.metallic, 0.25f);
  EXPECT_TRUE(material.varies(&DisneyParameters::metallic) && material.varies(&DisneyParameters::base_color));
  EXPECT_FALSE(material.varies(&DisneyParameters::specular) || material.varies(&DisneyParameters::emission));
  material.textures.clear();
  EXPECT_EQ(testing::evaluate_at(material, {0.5f, 0.75f}).base_color, material.constants.base_color);
}

TEST(DisneyMaterial, MultipliesTexturesScaledAndBiasedAndClampsTheProduct) {
  const auto half = std::make_shared<testing::MemoryTexture>(1, std::vector<Rgb>{{0.5f, 0.25f, 1}});
  DisneyMaterial material;
  material.constants.base_color = Rgb(1.0f);
  testing::connect("baseColor", half, &material);
  material.textures[0].lookup.scale = Rgb(4.0f), material.textures[0].lookup.bias = {0, 0.5f, -1};
  EXPECT_EQ(testing::evaluate_at(material, {0, 0}).base_color, Rgb(1, 1, 1)) << "2, 1.5 and 3";
  testing::connect("baseColor", half, &material);
  EXPECT_EQ(testing::evaluate_at(material, {0, 0}).base_color, Rgb(1, 0.375f, 1)) << "2/2, 1.5/4 and 3";
}

// In turns, counter-clockwise from growing red; scale and bias act on the angle, which stays within one turn.
TEST(DisneyMaterial, ReadsADirectionAsAnAngle) {
  const std::tuple<Rgb, float, float, float> kCases[] = {
      {{1, 0.5f, 0}, 1, 0, 0},     {{0.5f, 1, 9}, 1, 0, 0.25f},           {{0, 0.5f, 0}, 1, 0, 0.5f},
      {{0.5f, 0, 0}, 1, 0, 0.75f}, {{0.75f, 0.75f, 0}, 1, 0.25f, 0.375f}, {{0.5f, 0, 0}, 1, 0.5f, 0.25f},
      {{0.5f, 1, 0}, -1, 0, 0.75f}};
  for (const auto& [texel, scale, bias, turns] : kCases) {
    TextureLookup lookup;
    lookup.image = std::make_shared<testing::MemoryTexture>(1, std::vector<Rgb>{texel});
    lookup.scale = Rgb(scale), lookup.bias = Rgb(bias);
    DisneyMaterial material;
    material.constants.anisotropic_rotation = 1;
    material.textures.push_back({lookup, {{find_material_parameter("anisotropicRotation"), Channel::direction}}});
    EXPECT_NEAR(testing::evaluate_at(material, {0.5f, 0.5f}).anisotropic_rotation, turns, 1e-6f)
        << texel.r << " " << texel.g;
  }
}

TEST(DisneyMaterial, ReadsPrimvarsAndTextureCoordinatesByName) {
  Mesh mesh;
  mesh.triangles = {{0, 1, 2}};
  mesh.primvars = {{MeshAttribute<Vec3f>{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {}}, "tint"},
                   {MeshAttribute<float>{{0, 1, 0}, {}}, "wetness"}};
  mesh.uv_sets.resize(2);
  mesh.uv_sets[0].name = "st", mesh.uv_sets[1].name = "map2";
  mesh.uv_sets[1].values = {{0, 0}, {1, 0}, {0, 1}};
  TriangleHit hit;
  hit.u = 0.5f, hit.v = 0.25f;
  DisneyMaterial material;
  material.constants.base_color = Rgb(1.0f);
  material.constants.specular = 1;
  testing::connect("baseColor", nullptr, &material);
  material.textures[0].lookup.primvar = "tint";
  testing::connect("specularColor", std::make_shared<CountingTexture>(), &material);
  material.textures[1].lookup.primvar = "map2";
  material.textures[1].lookup.transform = {{0.125f, 0}, 0, {2, 1}};
  material.textures.push_back(material.textures[0]);
  material.textures[2].lookup.primvar = "wetness";
  material.textures[2].uses = {{find_material_parameter("specular"), Channel::r}};
  const DisneyParameters p = material.evaluate({mesh, hit, {9, 9}});
  EXPECT_EQ(p.base_color, Rgb(0.25f, 0.5f, 0.25f));
  EXPECT_EQ(p.specular, 0.5f);
  EXPECT_EQ(p.specular_color, Rgb(1.125f, 0.25f, 2));
  material.textures[1].lookup.primvar = "none";
  EXPECT_EQ(material.evaluate({mesh, hit, {9, 9}}).specular_color, Rgb(0.125f, 0, 2)) << "looked up at (0, 0)";
}

TEST(UvTransform, MatchesKhrTextureTransform) {
  EXPECT_EQ(UvTransform()({0.3f, -0.7f}), Vec2f(0.3f, -0.7f));
  // v down: (.25, .5) scaled (.5, 1) by (2, 2), turned by 90 degrees (y, -x) = (1, -.5), moved (1.1, -.3).
  const Vec2f uv = UvTransform({0.1f, 0.2f}, kPi / 2, {2, 2})({0.25f, 0.5f});
  EXPECT_NEAR(uv.x, 1.1f, 1e-6f);
  EXPECT_NEAR(uv.y, 1 + 0.3f, 1e-6f);
}

TEST(DisneyMaterial, ScatterDistanceMapMultipliesAndIsClamped) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  DisneyMaterial material;
  material.constants.scatter_distance = {0.5f, 0.25f, 2};
  const auto at = [&](const Rgb& texel) {
    material.textures.clear();
    testing::connect("scatterDistance", std::make_shared<testing::MemoryTexture>(1, std::vector<Rgb>{texel}),
                     &material);
    return testing::evaluate_at(material, {0.5f, 0.5f}).scatter_distance;
  };
  EXPECT_EQ(at({1, 4, 0.5f}), Rgb(0.5f, 1, 1));
  EXPECT_EQ(at({0, 1, 0}), Rgb(0, 0.25f, 0));
  EXPECT_EQ(at({-1, nan, inf}), Rgb(0, 0, 0)) << "such a texel does not scatter";
  EXPECT_EQ(testing::evaluate_at(material, {0.5f, 0.5f}).base_color, material.constants.base_color);
  EXPECT_TRUE(material.scatters()) << "by its constants: some texel may";
}

TEST(DisneyMaterial, ScatteringAndEmissionAreReported) {
  DisneyMaterial material;
  EXPECT_FALSE(material.scatters());
  EXPECT_FALSE(material.emits());
  material.constants.scatter_distance = {0, 0, 1e-6f};
  material.constants.emission = {0, 3, 0};
  EXPECT_TRUE(material.scatters());
  EXPECT_TRUE(material.emits());
}

TEST(DisneyMaterial, ProductsStayInTheirRangeAndFallBackToTheDefault) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  DisneyMaterial material;
  material.constants.base_color = Rgb(1.0f);
  const auto at = [&](const Rgb& texel) {
    material.textures.clear();
    testing::connect("baseColor", std::make_shared<testing::MemoryTexture>(1, std::vector<Rgb>{texel}), &material);
    return testing::evaluate_at(material, {0.5f, 0.5f}).base_color;
  };
  const float fallback = DisneyParameters().base_color.r;
  EXPECT_EQ(at({-1, 0.25f, 7}), Rgb(0, 0.25f, 1));
  EXPECT_EQ(at({nan, inf, -inf}), Rgb(fallback));
}

bool is_within(const MaterialParameter& row, double value) {
  return value >= row.minimum && value <= row.maximum;
}

TEST(MaterialParameters, DefaultsAreInRangeAndEveryMemberHasARow) {
  const DisneyParameters defaults;
  // The integrator sets two normals and the least roughness.
  size_t bytes = 2 * sizeof(DisneyParameters::coat_normal) + sizeof(DisneyParameters::least_roughness);
  for (const MaterialParameter& row : material_parameters()) {
    std::visit(
        [&](auto member) {
          bytes += sizeof(defaults.*member);
          if constexpr (std::is_same_v<decltype(member), Rgb DisneyParameters::*>) {
            for (int c = 0; c < 3; ++c) EXPECT_TRUE(is_within(row, (defaults.*member)[c])) << row.name;
          } else {
            EXPECT_TRUE(is_within(row, static_cast<double>(defaults.*member))) << row.name;
          }
        },
        row.member);
  }
  EXPECT_EQ((bytes + 3) / 4 * 4, sizeof(DisneyParameters)) << "thin, sides and opacity_mode share a word";
}

}  // namespace
}  // namespace alabaster
