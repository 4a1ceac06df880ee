// Every warp samples the pdf that it states, and the test rejects slightly wrong pdfs.
#include <gtest/gtest.h>

#include "core/camera/camera.h"
#include "core/sampling/distribution.h"
#include "core/sampling/warp.h"
#include "testenv/support/chi_square.h"

namespace alabaster::testing {
namespace {

TEST(WarpChiSquare, UniformSphere) {
  const auto sample = [](Rng& rng) -> std::optional<Vec3f> { return sample_uniform_sphere(uniform2(rng)); };
  const auto r = chi_square_sphere(sample, [](const Vec3f&) { return pdf_uniform_sphere(); });
  EXPECT_TRUE(plausible(r));
}

TEST(WarpChiSquare, CosineHemisphere) {
  const auto sample = [](Rng& rng) -> std::optional<Vec3f> { return sample_cosine_hemisphere(uniform2(rng)); };
  const auto r = chi_square_sphere(sample, [](const Vec3f& w) { return pdf_cosine_hemisphere(w); }, {.seed = 2});
  EXPECT_TRUE(plausible(r));
}

TEST(WarpChiSquare, BilinearDensity) {
  uint64_t seed = 20;
  for (const std::array<float, 4>& weights : {std::array<float, 4>{1, 1, 1, 1}, std::array<float, 4>{3, 0.5f, 1, 7},
                                              std::array<float, 4>{0, 0, 1e-3f, 0}, std::array<float, 4>{0, 2, 0, 5}}) {
    const BilinearDensity density{weights};
    const auto r = chi_square_square([&](Rng& rng) -> std::optional<Vec2f> { return density.sample(uniform2(rng)); },
                                     [&](const Vec2f& at) { return density.pdf(at); }, {.seed = seed++});
    EXPECT_TRUE(plausible(r));
  }
}

TEST(WarpChiSquare, UniformConeFromWideToNarrow) {
  for (float width : {1.7f, 0.3f, 1e-5f}) {
    const auto sample = [&](Rng& rng) -> std::optional<Vec3f> { return sample_uniform_cone(uniform2(rng), width); };
    const auto pdf = [&](const Vec3f& w) {
      const float one_minus_cos = w.z > 0 ? (w.x * w.x + w.y * w.y) / (1 + w.z) : 1 - w.z;
      return one_minus_cos <= width ? pdf_uniform_cone(width) : 0;
    };
    ChiSquareOptions options{.bins_x = 18, .bins_y = 18, .samples = 60000, .seed = 3};
    options.pole_exponent = width < 0.01f ? 8 : 1;
    const auto r = chi_square_sphere(sample, pdf, options);
    EXPECT_TRUE(plausible(r)) << width;
  }
}

// The disk in the square [0,1)^2: density 4/pi inside.
TEST(WarpChiSquare, ConcentricDisk) {
  const auto sample = [](Rng& rng) -> std::optional<Vec2f> {
    const Vec2f d = sample_concentric_disk(uniform2(rng));
    return Vec2f(std::min(0.5f * (d.x + 1), kOneMinusEpsilon), std::min(0.5f * (d.y + 1), kOneMinusEpsilon));
  };
  const auto pdf = [](const Vec2f& p) { return sqr(2 * p.x - 1) + sqr(2 * p.y - 1) <= 1 ? 4 * kInvPi : 0; };
  const auto r = chi_square_square(sample, pdf, {.seed = 4});
  EXPECT_TRUE(plausible(r));
}

// The aperture's polygon in the square [0,1)^2, which the polygon's corners reach at most.
TEST(WarpChiSquare, ApertureBlades) {
  for (const uint32_t blades : {3u, 6u}) {
    CameraParameters p;
    p.focal_length = 2, p.f_stop = 1, p.focus_distance = 10;  // a radius of one
    p.aperture_blades = blades;
    p.aperture_rotation = 15;
    const Camera camera(p, 1, 1, {0, 0, 0});
    const auto n = static_cast<float>(blades);
    const float radius = std::sqrt(kTwoPi / (n * std::sin(kTwoPi / n)));
    const auto sample = [&](Rng& rng) -> std::optional<Vec2f> {
      const Vec3f q = camera.generate_ray({0.5f, 0.5f}, uniform2(rng)).org * (0.5f / radius) + Vec3f(0.5f);
      return Vec2f(std::min(q.x, kOneMinusEpsilon), std::min(q.y, kOneMinusEpsilon));
    };
    const auto pdf = [&](const Vec2f& at) {
      const Vec2f q = (at - Vec2f(0.5f)) * (2 * radius);
      const float sector = kTwoPi / n, angle = std::atan2(q.y, q.x) - 15 * kPi / 180;
      const float within = angle - sector * std::floor(angle / sector) - sector / 2;
      return q.length() * std::cos(within) <= radius * std::cos(sector / 2) ? 4 * radius * radius * kInvPi : 0.0f;
    };
    const auto r = chi_square_square(sample, pdf, {.seed = 10 + blades});
    EXPECT_TRUE(plausible(r)) << blades;
  }
}

TEST(WarpChiSquare, UniformTriangle) {
  const auto sample = [](Rng& rng) -> std::optional<Vec2f> { return sample_uniform_triangle(uniform2(rng)); };
  const auto pdf = [](const Vec2f& b) { return b.x + b.y <= 1 ? 2.0f : 0.0f; };
  const auto r = chi_square_square(sample, pdf, {.seed = 5});
  EXPECT_TRUE(plausible(r));
}

TEST(WarpChiSquare, PiecewiseConstantDistributions) {
  const Distribution2D d({0, 1, 2, 0.25f, 0, 0, 0, 0, 5, 0, 1, 1, 0, 0, 0, 9}, 4, 4);
  const auto sample = [&](Rng& rng) -> std::optional<Vec2f> {
    const auto cell = d.sample(uniform2(rng));
    return Vec2f((static_cast<float>(cell.x) + cell.remapped.x) / 4,
                 (static_cast<float>(cell.y) + cell.remapped.y) / 4);
  };
  const auto pdf = [&](const Vec2f& p) {
    const auto in = [](float x) { return static_cast<size_t>(std::min(x * 4, 3.0f)); };
    return 16 * d.probability(in(p.x), in(p.y));
  };
  const auto r = chi_square_square(sample, pdf, {.seed = 6});
  EXPECT_TRUE(plausible(r));
}

// Cells of one, two and three steps of the random numbers: probabilities rounded by a float cdf are exactly those
// stated.
TEST(WarpChiSquare, SteepDistributionIsDrawnAsClaimed) {
  std::vector<float> weights(4096, 1.0f);
  weights[100] = 5e6f;
  const Distribution1D d(weights);
  double rest = 0;
  for (size_t i = 0; i < weights.size(); ++i) rest += i == 100 ? 0 : static_cast<double>(d.probability(i));
  // Exhaustive over all 24-bit numbers rather than sampled.
  std::vector<uint32_t> counts(weights.size());
  for (uint32_t i = 0; i < (1u << 24); ++i) ++counts[d.sample(static_cast<float>(i) * 0x1p-24f).index];
  for (size_t i = 0; i < weights.size(); ++i) {
    ASSERT_EQ(static_cast<float>(counts[i]) * 0x1p-24f, d.probability(i)) << i;
    ASSERT_GT(counts[i], 0u) << i;
  }
  EXPECT_NEAR(rest, 4095 / (5e6 + 4095), 2e-5);
}

TEST(WarpChiSquare, WrongPdfsFail) {
  const auto cone = [](Rng& rng) -> std::optional<Vec3f> { return sample_uniform_cone(uniform2(rng), 0.3f); };
  const auto wider = [](const Vec3f& w) { return 1 - w.z <= 0.31f ? pdf_uniform_cone(0.31f) : 0; };
  EXPECT_TRUE(noticed(chi_square_sphere(cone, wider)));
  // The classic mistake: omitting the square root.
  const auto crowded = [](Rng& rng) -> std::optional<Vec2f> {
    const Vec2f u = uniform2(rng);
    return Vec2f(1 - u.x, u.y * u.x);
  };
  EXPECT_TRUE(noticed(chi_square_square(crowded, [](const Vec2f& b) { return b.x + b.y <= 1 ? 2.0f : 0.0f; })));
}

}  // namespace
}  // namespace alabaster::testing
