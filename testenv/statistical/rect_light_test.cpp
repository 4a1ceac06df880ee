// Rectangle lights that are sampled by the irradiances of their corners.
#include <gtest/gtest.h>

#include "core/light/plane_light.h"
#include "testenv/support/chi_square.h"
#include "testenv/support/z_test.h"

namespace alabaster::testing {
namespace {

constexpr int kTests = 4;  // in this file
struct Plane {
  Vec3f p, n;
};

// The cosine of a plane decides which samples are taken, and not their mean, also where part of the rectangle is below.
TEST(RectLight, ALobeChangesTheSamplesAlone) {
  LightDescription d;
  d.width = 2;
  d.height = 0.5f;
  d.color = Rgb(3, 1, 1);
  d.light_to_world = Matrix4d(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 3, 1);
  const PlaneLight light(d, Vec3d(0, 0, 0));
  uint64_t seed = 160;
  for (const Plane& plane : {Plane{{0, 0, 0}, {0, 0, 1}}, Plane{{3, 2, 0}, normalize(Vec3f(-1, 0, 1))},
                             Plane{{0.5f, 0, 0}, {1, 0, 0}}, Plane{{-300, 0, 0}, normalize(Vec3f(1, 0, 1))}}) {
    Rng rng(seed++, 1);
    RunningStatistics for_lobe, without;
    for (int i = 0; i < 40000; ++i) {
      const auto estimate = [&](const std::optional<LightSample>& s) {
        return s ? static_cast<double>(s->radiance.r * std::max(0.0f, dot(s->wi, plane.n)) / s->pdf) : 0.0;
      };
      for_lobe.add(estimate(light.sample(plane.p, uniform2(rng), plane.n)));
      without.add(estimate(light.sample(plane.p, uniform2(rng))));
    }
    const double error = std::hypot(for_lobe.standard_error(), without.standard_error());
    const auto r = z_test(for_lobe, without.mean(), {.number_of_tests = kTests, .slack = 3 * error});
    EXPECT_TRUE(r.passed) << r.report;
    EXPECT_LT(for_lobe.variance(), without.variance());
  }
}

// kNearRectangle: at the nearest points that are sampled by the corners' irradiances, the sum of the variances is less
// than by solid angle.
TEST(RectLight, IsSampledWithLessNoiseFromAfar) {
  Rng rng(170, 1);
  double by_corners = 0, by_solid_angle = 0;
  for (int i = 0; i < 400; ++i) {
    LightDescription d;
    d.width = 0.2f + 2 * rng.uniform();
    d.height = 0.2f + 2 * rng.uniform();
    const PlaneLight light(d, Vec3d(0, 0, 0));
    const Vec3f to_light = sample_uniform_cone(uniform2(rng), 0.9f);
    const float half_diagonal = 0.5f * std::hypot(d.width, d.height);
    const Plane plane{to_light * (-2.001f * half_diagonal), sample_cosine_hemisphere(uniform2(rng))};
    const auto x = [&](double side) { return (0.5 * d.width * side - plane.p.x) / -plane.p.z; };
    const auto y = [&](double side) { return (0.5 * d.height * side - plane.p.y) / -plane.p.z; };
    const SphericalRectangle seen(x(-1), x(1), y(-1), y(1));
    RunningStatistics corners, solid_angle;
    for (int k = 0; k < 300; ++k) {
      const auto s = light.sample(plane.p, uniform2(rng), plane.n);
      ASSERT_TRUE(s);
      corners.add(static_cast<double>(std::max(0.0f, dot(s->wi, plane.n)) / s->pdf));
      const Vec3d w = seen.sample(uniform2(rng));
      solid_angle.add(std::max(0.0, dot(w, Vec3d(plane.n))) * seen.solid_angle());
    }
    const double scale = 1 / std::max(1e-6, solid_angle.mean() * solid_angle.mean());
    by_corners += corners.variance() * scale;
    by_solid_angle += solid_angle.variance() * scale;
  }
  EXPECT_LT(by_corners, 0.8 * by_solid_angle);
}

}  // namespace
}  // namespace alabaster::testing
