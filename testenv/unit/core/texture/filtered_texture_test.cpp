#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <random>

#include "core/geometry/surface_hit.h"
#include "core/texture/texel_pyramid.h"
#include "core/texture/texel_store.h"
#include "core/texture/texture.h"
#include "core/texture/uv_transform.h"
#include "testenv/support/reports.h"

namespace alabaster {
namespace {

// RGBA pixels, rows from the top.
struct Picture {
  Vec2i size;
  std::vector<float> rgba;
  const float* at(int x, int y) const { return &rgba[4 * size_t(y * size.x + x)]; }
};

Picture noise(const Vec2i& size, bool opaque) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> unit(0, 1);
  Picture picture{size, {}};
  for (int i = 0; i < size.x * size.y; ++i) {
    for (int c = 0; c < 3; ++c) picture.rgba.push_back(Imath::half(unit(random)));
    picture.rgba.push_back(opaque ? 1.0f : float(random() % 2));
  }
  return picture;
}

std::shared_ptr<const Texture> load(const Picture& picture, const std::shared_ptr<TexelStore>& store = nullptr,
                                    Wrap wrap = Wrap::repeat) {
  const std::string file =
      (std::filesystem::temp_directory_path() / ("alabaster_pyramid_" + std::to_string(::getpid()) + ".tif")).string();
  OIIO::ImageSpec spec(picture.size.x, picture.size.y, 4, OIIO::TypeFloat);
  spec.attribute("oiio:UnassociatedAlpha", 1);
  const auto out = OIIO::ImageOutput::create(file);
  EXPECT_TRUE(out->open(file, spec) && out->write_image(OIIO::TypeFloat, picture.rgba.data()) && out->close());
  testing::Reports reports;
  auto texture = load_texture({file, nullptr, "raw", wrap, wrap}, *ColorConfig::load("built-in", {}), reports.sink,
                              {.store = store});
  EXPECT_TRUE(texture && texture->prepare_filtering()) << reports.text();
  std::filesystem::remove(file);
  return texture;
}

// The mean over boxes of side x side texels, each by its alpha, a transparent one by a little.
Rgb box_mean(const Picture& picture, int side, int x, int y) {
  double sum[4] = {};
  for (int j = 0; j < side; ++j)
    for (int i = 0; i < side; ++i) {
      const float* const p = picture.at(x * side + i, y * side + j);
      const double weight = std::max(double(p[3]), 1.0 / 1024);
      for (int c = 0; c < 3; ++c) sum[c] += double(p[c]) * weight;
      sum[3] += weight;
    }
  return Rgb(float(sum[0] / sum[3]), float(sum[1] / sum[3]), float(sum[2] / sum[3]));
}

void expect_near(const Rgb& a, const Rgb& b, float tolerance, const std::string& where) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], tolerance) << where;
}

TEST(FilteredTexture, LevelsAreMeansOfBoxes) {
  for (const bool opaque : {true, false}) {
    const Picture picture = noise({64, 32}, opaque);
    const auto texture = load(picture);
    for (int side = 2; side <= 16; side *= 2)
      for (int y = 0; y < 32 / side; ++y)
        for (int x = 0; x < 64 / side; ++x) {
          const Vec2f centre((float(x) + 0.5f) * float(side) / 64, 1 - (float(y) + 0.5f) * float(side) / 32);
          expect_near(texture->filtered(centre, float(side)), box_mean(picture, side, x, y), 3e-4f,
                      std::to_string(side) + " at " + std::to_string(x) + "," + std::to_string(y));
        }
  }
}

TEST(FilteredTexture, OddSizesKeepTheMean) {
  for (const Vec2i& size : {Vec2i(7, 1), Vec2i(13, 5), Vec2i(101, 67), Vec2i(3, 64)}) {
    const Picture picture = noise(size, true);
    double sum[3] = {};
    for (size_t i = 0; i < picture.rgba.size(); ++i)
      if (i % 4 < 3) sum[i % 4] += double(picture.rgba[i]) / (size.x * size.y);
    expect_near(load(picture)->filtered({0.3f, 0.6f}, 1e9f), {float(sum[0]), float(sum[1]), float(sum[2])}, 4e-4f,
                std::to_string(size.x));
  }
}

// Against the brute mean of lookups, on an image that varies slowly beside the footprint.
// promise: trade_off.bias.texture_filter
TEST(FilteredTexture, IsTheMeanOfLookupsOverTheFootprint) {
  constexpr int kSize = 256;
  Picture picture{{kSize, kSize}, {}};
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      const float wave = 0.5f + 0.25f * std::sin(2 * kPi * float(x) / kSize) + 0.2f * float((x + y) % 2);
      picture.rgba.insert(picture.rgba.end(), {wave, 0.2f * float(x % 2), 0.5f, 1});
    }
  const auto texture = load(picture);
  std::mt19937 random(3);
  std::uniform_real_distribution<float> unit(0, 1);
  for (const float width : {2.0f, 3.0f, 5.5f, 8.0f})
    for (int trial = 0; trial < 20; ++trial) {
      const Vec2f uv(unit(random), unit(random));
      constexpr int kTaps = 64;
      Rgb sum;
      for (int i = 0; i < kTaps * kTaps; ++i) {
        // Two texels are one period of the fine pattern.
        const Vec2f offset((float(i % kTaps) + 0.5f) / kTaps - 0.5f, (float(i / kTaps) + 0.5f) / kTaps - 0.5f);
        sum += texture->rgb(uv + offset * (std::ceil(width / 2) * 2 / kSize)) * (1.0f / (kTaps * kTaps));
      }
      // The pyramid's mean is over a tent and not over a box; between two levels some of the pattern is left.
      expect_near(texture->filtered(uv, width), sum, 0.012f, std::to_string(width));
    }
}

TEST(FilteredTexture, IsTheLookupForNarrowFootprintsAndTheSameInATightStore) {
  const Picture picture = noise({200, 150}, false);
  const auto tight = std::make_shared<TexelStore>();
  tight->set_budget(0);
  std::mt19937 random(4);
  std::uniform_real_distribution<float> unit(-1, 2);
  for (const Wrap wrap : {Wrap::repeat, Wrap::mirror, Wrap::clamp, Wrap::black}) {
    const auto ample = load(picture, nullptr, wrap), paged = load(picture, tight, wrap);
    EXPECT_LT(paged->memory_bytes(), 2000u);
    for (int i = 0; i < 2000; ++i) {
      const Vec2f uv(unit(random), unit(random));
      const float width = std::exp2(8 * unit(random));
      ASSERT_EQ(ample->filtered(uv, width), paged->filtered(uv, width));
      ASSERT_EQ(ample->filtered(uv, 1), ample->rgb(uv));
      ASSERT_EQ(ample->filtered(uv, std::nanf("")), ample->rgb(uv));
    }
  }
}

// A sheared triangle under a transform that scales unevenly: the rates are those of uv along directions in render
// space.
TEST(SurfaceFootprint, CoversTexelsAlongItsNarrowestDirection) {
  Mesh mesh;
  mesh.points = {{0, 0, 0}, {2, 0, 0}, {0.5f, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  mesh.uv_sets.push_back({{}, "st"});
  for (const Vec3f& p : mesh.points) mesh.uv_sets[0].values.emplace_back(3 * p.x, 0.5f * p.x + 0.25f * p.y);
  Affine to_render;
  to_render.x = {2, 0, 0}, to_render.y = {0, 0, 4}, to_render.z = {0, 1, 0};
  TriangleHit hit;
  hit.triangle = 0;
  const HitPrimvars at(mesh, hit, {0, 0}, {1, &to_render});
  const Vec3f m = at.uv_metric("st");
  // u = 3/2 X, v = X/4 + Z/16.
  EXPECT_NEAR(m.x, 9.0f / 4, 1e-5f);
  EXPECT_NEAR(m.y, 3.0f / 8, 1e-5f);
  EXPECT_NEAR(m.z, 1.0f / 16 + 1.0f / 256, 1e-6f);
  EXPECT_EQ(at.uv_metric("none"), Vec3f(0, 0, 0));
  // By brute force over directions, with the transform's own scale and turn.
  const UvTransform transform({0.1f, 0.2f}, 0.7f, {2, 0.5f});
  float least = 1e9f;
  for (int i = 0; i < 10000; ++i) {
    const float a = kPi * float(i) / 10000, x = std::cos(a), z = std::sin(a);
    const Vec2f end = transform({1.5f * x, x / 4 + z / 16}) - transform({0, 0});
    least = std::min(least, std::hypot(end.x * 512, end.y * 128));
  }
  EXPECT_NEAR(transform.texels_across(0.25f, m, {512, 128}), 0.25f * least, 1e-3f * least);
  mesh.points[2] = {4, 0, 0};
  EXPECT_EQ(at.uv_metric("st"), Vec3f(0, 0, 0)) << "a triangle without area";
}

}  // namespace
}  // namespace alabaster
