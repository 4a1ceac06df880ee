// Rectangle lights that are sampled by the irradiances of their corners.
#include <gtest/gtest.h>

#include "core/light/rect_disk_light.h"
#include "core/light/spherical_rectangle.h"
#include "testenv/support/chi_square.h"
#include "testenv/support/z_test.h"

namespace alabaster::testing {
namespace {

struct Receiver {
  Vec3f p, n;
};

// The cosine of a plane decides which samples are taken, and not their mean, also where part of the rectangle is below.
TEST(RectLight, ALobeChangesTheSamplesAlone) {
  LightParameters d;
  d.width = 2;
  d.height = 0.5f;
  d.color = Rgb(3, 1, 1);
  d.light_to_world = Matrix4d(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 3, 1);
  const RectDiskLight light(d, Vec3d(0, 0, 0));
  uint64_t seed = 160;
  for (const Receiver& plane : {Receiver{{0, 0, 0}, {0, 0, 1}}, Receiver{{3, 2, 0}, normalize(Vec3f(-1, 0, 1))},
                                Receiver{{0.5f, 0, 0}, {1, 0, 0}}, Receiver{{-30, 0, 0}, normalize(Vec3f(1, 0, 1))}}) {
    Rng rng(run_seed(seed++), 1);
    // By solid angle, from the same height below the rectangle.
    const auto seen_at = [&](double edge, float from) {
      return (edge - static_cast<double>(from)) / (3.0 - plane.p.z);
    };
    const SphericalRectangle seen(seen_at(-1, plane.p.x), seen_at(1, plane.p.x), seen_at(-0.25, plane.p.y),
                                  seen_at(0.25, plane.p.y));
    RunningStatistics by_solid_angle, difference;
    for (int i = 0; i < run_samples(40000); ++i) {
      const auto s = light.sample(plane.p, uniform2(rng), plane.n);
      ASSERT_TRUE(s);
      const double one = static_cast<double>(s->radiance.r * std::max(0.0f, dot(s->wi, plane.n)) / s->pdf);
      const double other = 3 * std::max(0.0, dot(seen.sample(uniform2(rng)), Vec3d(plane.n))) * seen.solid_angle();
      by_solid_angle.add(other);
      difference.add(one - other);
    }
    const auto r = z_test(difference, 0, {.slack = 2e-6 * by_solid_angle.mean()});
    EXPECT_TRUE(plausible(r));
  }
}

// kNearRectangle: at the nearest points that are sampled by the corners' irradiances, the sum of the variances is less
// than by solid angle.
TEST(RectLight, IsSampledWithLessNoiseFromAfar) {
  Rng rng(run_seed(170), 1);
  double by_corners = 0, by_solid_angle = 0;
  for (int i = 0; i < 400; ++i) {
    LightParameters d;
    d.width = 0.2f + 2 * rng.uniform();
    d.height = 0.2f + 2 * rng.uniform();
    const RectDiskLight light(d, Vec3d(0, 0, 0));
    const Vec3f to_light = sample_uniform_cone(uniform2(rng), 0.9f);
    const float half_diagonal = 0.5f * std::hypot(d.width, d.height);
    const Receiver plane{to_light * (-2.001f * half_diagonal), sample_cosine_hemisphere(uniform2(rng))};
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
