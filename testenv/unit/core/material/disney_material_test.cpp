#include "core/material/disney_material.h"

#include <gtest/gtest.h>

#include <limits>

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

TEST(DisneyMaterial, ReadsItsMapOnceAndMultiplies) {
  const auto map = std::make_shared<CountingTexture>();
  DisneyMaterial material;
  material.constants.base_color = {0.5f, 0.25f, 0.8f};
  material.constants.roughness = 0.3f;
  material.base_color_map = map;
  const DisneyParameters p = material.evaluate({0.5f, 0.75f});
  EXPECT_EQ(map->reads, 1);
  EXPECT_EQ(p.base_color, Rgb(0.25f, 0.1875f, 1));  // the last channel clamped
  EXPECT_EQ(p.roughness, 0.3f);
  material.base_color_map = nullptr;
  EXPECT_EQ(material.evaluate({0.5f, 0.75f}).base_color, material.constants.base_color);
}

TEST(DisneyMaterial, ScatterDistanceMapMultipliesAndIsClamped) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  DisneyMaterial material;
  material.constants.scatter_distance = {0.5f, 0.25f, 2};
  const auto at = [&](const Rgb& texel) {
    material.scatter_distance_map = std::make_shared<testing::MemoryTexture>(1, std::vector<Rgb>{texel});
    return material.evaluate({0.5f, 0.5f}).scatter_distance;
  };
  EXPECT_EQ(at({1, 4, 0.5f}), Rgb(0.5f, 1, 1));
  EXPECT_EQ(at({0, 1, 0}), Rgb(0, 0.25f, 0));
  EXPECT_EQ(at({-1, nan, inf}), Rgb(0, 0, 0)) << "such a texel does not scatter";
  EXPECT_EQ(material.evaluate({0.5f, 0.5f}).base_color, material.constants.base_color);
  EXPECT_TRUE(material.scatters()) << "by its constants: some texel may";
}

TEST(DisneyMaterial, SaysWhatItDoes) {
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
    material.base_color_map = std::make_shared<testing::MemoryTexture>(1, std::vector<Rgb>{texel});
    return material.evaluate({0.5f, 0.5f}).base_color;
  };
  const float fallback = DisneyParameters().base_color.r;
  EXPECT_EQ(at({-1, 0.25f, 7}), Rgb(0, 0.25f, 1));
  EXPECT_EQ(at({nan, inf, -inf}), Rgb(fallback));
}

TEST(MaterialParameters, DefaultsAreInRangeAndEveryMemberHasARow) {
  const DisneyParameters defaults;
  size_t bytes = 0;
  for (const MaterialParameter& row : material_parameters()) {
    bytes += row.is_color() ? sizeof(Rgb) : sizeof(float);
    for (int c = 0; c < 3; ++c) {
      const float value = row.is_color() ? (defaults.*std::get<Rgb DisneyParameters::*>(row.member))[c]
                                         : defaults.*std::get<float DisneyParameters::*>(row.member);
      EXPECT_GE(value, row.minimum) << row.name;
      EXPECT_LE(value, row.maximum) << row.name;
    }
  }
  EXPECT_EQ(bytes, sizeof(DisneyParameters));
}

}  // namespace
}  // namespace alabaster
