// Tests the statistical tests: they must accept correct densities and reject slightly wrong ones.
#include "testenv/support/chi_square.h"

#include <gtest/gtest.h>

#include "core/sampling/warp.h"
#include "testenv/support/z_test.h"

namespace alabaster::testing {
namespace {

TEST(GammaQ, MatchesClosedForms) {
  for (double x : {1e-3, 0.1, 0.5, 1.0, 2.0, 5.0, 20.0, 60.0}) {
    const double e = std::exp(-x);
    EXPECT_NEAR(gamma_q(0.5, x), std::erfc(std::sqrt(x)), 1e-13);
    EXPECT_NEAR(gamma_q(1, x), e, 1e-13);
    EXPECT_NEAR(gamma_q(4, x), e * (1 + x + x * x / 2 + x * x * x / 6), 1e-13);
  }
  // Recurrence Q(a+1, x) = Q(a, x) + x^a e^-x / Gamma(a+1) at the size of a real test.
  const double a = 700, x = 720;
  EXPECT_NEAR(gamma_q(a + 1, x) - gamma_q(a, x), std::exp(a * std::log(x) - x - std::lgamma(a + 1)), 1e-12);
}

TEST(IntegrateRectangle, SmoothAndWithAJump) {
  const auto smooth = [](double x, double y) { return std::exp(x) * y * y; };
  EXPECT_NEAR(integrate_rectangle(smooth, {0, 1}, {0, 2}, 1e-9), (std::exp(1.0) - 1) * 8 / 3, 1e-9);
  const auto jump = [](double x, double y) { return x + y < 1 ? 2.0 : 0.0; };
  EXPECT_NEAR(integrate_rectangle(jump, {0, 1}, {0, 1}, 1e-4), 1, 1e-3);
}

TEST(IntegrateSphere, AnyFrame) {
  const Frame frame = frame_from_normal(normalize(Vec3f(-3, 1, 2)));
  const auto cosine = [](const Vec3f& w) { return static_cast<double>(pdf_cosine_hemisphere(w)); };
  for (double k : {1.0, 2.0, 6.0}) EXPECT_NEAR(integrate_sphere(cosine, frame, k), 1, 2e-5);
}

TEST(ChiSquare, AcceptsCosineHemisphere) {
  const auto sample = [](Rng& rng) -> std::optional<Vec3f> { return sample_cosine_hemisphere(uniform2(rng)); };
  const auto result = chi_square_sphere(sample, [](const Vec3f& w) { return pdf_cosine_hemisphere(w); });
  EXPECT_TRUE(plausible(result));
  EXPECT_NEAR(result.pdf_integral, 1, 1e-5);
}

TEST(ChiSquare, CountsMissingSamplesAsABin) {
  const auto half = [](Rng& rng) -> std::optional<Vec3f> {
    const Vec3f w = sample_uniform_sphere(uniform2(rng));
    if (w.z < 0) return std::nullopt;
    return w;
  };
  const auto upper = [](const Vec3f& w) { return w.z >= 0 ? pdf_uniform_sphere() : 0; };
  const auto result = chi_square_sphere(half, upper);
  EXPECT_TRUE(plausible(result));
  EXPECT_NEAR(result.pdf_integral, 0.5, 1e-5);
  // Twice the density would be right if the missing half had been sampled again.
  EXPECT_TRUE(noticed(chi_square_sphere(half, [&](const Vec3f& w) { return 2 * upper(w); })));
}

TEST(ChiSquare, RefusesWrongPdfs) {
  const auto cosine = [](Rng& rng) -> std::optional<Vec3f> { return sample_cosine_hemisphere(uniform2(rng)); };
  // Wrong by at most 10 % in a smooth way, still normalized: noncentrality n 0.1^2 E[x^2] = 500, twelve sigma.
  const auto tilted = [](const Vec3f& w) { return pdf_cosine_hemisphere(w) * (1 + 0.1f * w.x); };
  EXPECT_TRUE(noticed(chi_square_sphere(cosine, tilted)));
  EXPECT_TRUE(noticed(chi_square_sphere(cosine, [](const Vec3f&) { return pdf_uniform_sphere(); })));
  EXPECT_TRUE(noticed(chi_square_sphere(cosine, [](const Vec3f&) { return std::nanf(""); })));
  const auto sphere = [](Rng& rng) -> std::optional<Vec3f> { return sample_uniform_sphere(uniform2(rng)); };
  EXPECT_TRUE(noticed(chi_square_sphere(sphere, [](const Vec3f& w) { return pdf_cosine_hemisphere(w); })));
  const auto scaled = [](Rng& rng) -> std::optional<Vec3f> { return sample_cosine_hemisphere(uniform2(rng)) * 1.1f; };
  EXPECT_TRUE(noticed(chi_square_sphere(scaled, [](const Vec3f& w) { return pdf_cosine_hemisphere(w); })));
}

TEST(ChiSquare, TurnedFrameAndFinePole) {
  const Frame frame = frame_from_normal(normalize(Vec3f(1, 2, -3)));
  const float width = 1e-4f;
  const auto cone = [&](Rng& rng) -> std::optional<Vec3f> {
    return frame.to_world(sample_uniform_cone(uniform2(rng), width));
  };
  ChiSquareOptions options;
  options.frame = frame;
  options.pole_exponent = 6;
  options.bins_x = options.bins_y = 16;
  const auto pdf = [&](float w) {
    return [&frame, w](const Vec3f& d) {
      const Vec3f l = frame.to_local(d);
      return l.z > 0 && 1 - std::sqrt(1 - l.x * l.x - l.y * l.y) < w ? pdf_uniform_cone(w) : 0;
    };
  };
  const auto result = chi_square_sphere(cone, pdf(width), options);
  EXPECT_TRUE(plausible(result));
  EXPECT_TRUE(noticed(chi_square_sphere(cone, pdf(1.03f * width), options)));
}

TEST(ChiSquare, SquareDomain) {
  const auto triangle = [](Rng& rng) -> std::optional<Vec2f> { return sample_uniform_triangle(uniform2(rng)); };
  const auto pdf = [](const Vec2f& b) { return b.x + b.y < 1 ? 2.0f : 0.0f; };
  const auto result = chi_square_square(triangle, pdf);
  EXPECT_TRUE(plausible(result));
  const auto uniform = [](Rng& rng) -> std::optional<Vec2f> { return uniform2(rng); };
  EXPECT_TRUE(noticed(chi_square_square(uniform, pdf)));
  EXPECT_TRUE(plausible(chi_square_square(uniform, [](const Vec2f&) { return 1.0f; })));
}

TEST(ChiSquare, PValuesAreUniformWhenTheSamplerIsRight) {
  // 200 seeds: the smallest p of 200 uniform ones lies below 1e-5 with probability 0.2 %, the mean within 0.5 +- 0.08.
  RunningStatistics p;
  for (uint64_t seed = 0; seed < 200; ++seed) {
    ChiSquareOptions options;
    options.bins_x = options.bins_y = 8;
    options.samples = 2000;
    options.seed = seed;
    const auto uniform = [](Rng& rng) -> std::optional<Vec2f> { return uniform2(rng); };
    const auto result = chi_square_square(
        uniform, [](const Vec2f&) { return 1.0f; }, options);
    EXPECT_GT(result.p_value, 1e-5);
    p.add(result.p_value);
  }
  EXPECT_NEAR(p.mean(), 0.5, 4 / std::sqrt(12.0 * 200));
  EXPECT_NEAR(p.variance(), 1.0 / 12, 0.03);
}

TEST(ZTest, AcceptsTheMeanAndRefusesTheNearMiss) {
  Rng rng(run_seed(7), 1);
  RunningStatistics values;
  for (int i = 0; i < run_samples(100000); ++i) values.add(static_cast<double>(rng.uniform()));
  EXPECT_TRUE(plausible(z_test(values, 0.5)));
  EXPECT_NEAR(values.variance(), 1.0 / 12, 1e-3);
  EXPECT_TRUE(noticed(z_test(values, 0.505)));
  EXPECT_TRUE(plausible(z_test(values, 0.505, {.slack = 0.005})));
  EXPECT_TRUE(noticed(z_test(values, std::nan(""))));
}

TEST(ZTest, ZeroVarianceNeedsExactness) {
  RunningStatistics values;
  for (int i = 0; i < 10; ++i) values.add(0.25);
  EXPECT_TRUE(plausible(z_test(values, 0.25)));
  EXPECT_TRUE(noticed(z_test(values, 0.2500001)));
}

TEST(ZTest, SidakLevel) {
  EXPECT_DOUBLE_EQ(sidak_level(0.01, 1), 0.01);
  const double level = sidak_level(0.01, 50);
  EXPECT_NEAR(std::pow(1 - level, 50), 0.99, 1e-12);
}

}  // namespace
}  // namespace alabaster::testing
