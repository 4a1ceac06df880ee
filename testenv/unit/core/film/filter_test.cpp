#include "core/film/filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

namespace alabaster {
namespace {

// Mass of a filter's density in [a, b] by the midpoint rule.
double mass(const std::function<double(double)>& density, double a, double b) {
  constexpr int kSteps = 20000;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) sum += density(a + (i + 0.5) * (b - a) / kSteps);
  return sum * (b - a) / kSteps;
}

// The warp is monotonic: the share of u below the one that gives x is the filter's mass below x.
void expect_matches(PixelFilter filter, double radius, const std::function<double(double)>& density) {
  const double total = mass(density, -radius, radius);
  for (int i = 1; i < 64; ++i) {
    const double u = i / 64.0;
    const double x = sample_pixel_filter(filter, {static_cast<float>(u), 0.5f}).x;
    EXPECT_NEAR(mass(density, -radius, x) / total, u, 2e-4) << "u = " << u;
    EXPECT_LE(std::abs(x), radius);
  }
}

TEST(PixelFilter, SamplesFollowTheirDensities) {
  expect_matches(PixelFilter::box, 0.5, [](double) { return 1.0; });
  expect_matches(PixelFilter::triangle, 1, [](double x) { return 1 - std::abs(x); });
  expect_matches(PixelFilter::gaussian, 1.5, [](double x) { return std::exp(-2 * x * x); });
  expect_matches(PixelFilter::blackman_harris, 1.5, [](double x) {
    const double t = 2 * M_PI * (x + 1.5) / 3;
    return 0.35875 - 0.48829 * std::cos(t) + 0.14128 * std::cos(2 * t) - 0.01168 * std::cos(3 * t);
  });
}

TEST(PixelFilter, AxesAreIndependent) {
  const Vec2f a = sample_pixel_filter(PixelFilter::gaussian, {0.2f, 0.9f});
  EXPECT_EQ(a.x, sample_pixel_filter(PixelFilter::gaussian, {0.2f, 0.1f}).x);
  EXPECT_EQ(a.y, sample_pixel_filter(PixelFilter::gaussian, {0.7f, 0.9f}).y);
}

}  // namespace
}  // namespace alabaster
