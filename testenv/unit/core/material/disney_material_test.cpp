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

TEST(DisneyParameters, DefaultsAreInRange) {
  const DisneyParameters p, q = clamp_to_ranges(p);
  EXPECT_EQ(p.base_color, q.base_color);
  EXPECT_EQ(p.ior, q.ior);
  EXPECT_EQ(p.specular_color, q.specular_color);
  EXPECT_EQ(p.scatter_distance, q.scatter_distance);
}

TEST(DisneyParameters, ClampsAndReplacesNonFinite) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  DisneyParameters p;
  p.base_color = {-1, nan, 7};
  p.metallic = 2;
  p.roughness = nan;
  p.anisotropic = -inf;
  p.specular_tint = 1.5f;
  p.ior = 0.5f;
  p.specular = inf;
  p.specular_color = {-1, 5, nan};
  p.sheen = -3;
  p.sheen_tint = nan;
  p.clearcoat = 9;
  p.clearcoat_gloss = -9;
  p.scatter_distance = {nan, inf, -2};
  p.emission = {1e30f, -1, inf};
  const DisneyParameters q = clamp_to_ranges(p), d;
  EXPECT_EQ(q.base_color, Rgb(0, d.base_color.g, 1));
  EXPECT_EQ(q.metallic, 1);
  EXPECT_EQ(q.roughness, d.roughness);
  EXPECT_EQ(q.anisotropic, d.anisotropic);
  EXPECT_EQ(q.specular_tint, 1);
  EXPECT_EQ(q.ior, 1);
  EXPECT_EQ(q.specular, d.specular);
  EXPECT_EQ(q.specular_color, Rgb(0, 5, 1));
  EXPECT_EQ(q.sheen, 0);
  EXPECT_EQ(q.sheen_tint, d.sheen_tint);
  EXPECT_EQ(q.clearcoat, 1);
  EXPECT_EQ(q.clearcoat_gloss, 0);
  EXPECT_EQ(q.scatter_distance, Rgb(0.0f));
  EXPECT_EQ(q.emission, Rgb(1e30f, 0, 0));
}

}  // namespace
}  // namespace alabaster
