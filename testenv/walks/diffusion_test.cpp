// Normalized diffusion by the probes that render, compared with integrals of its profile.
#include <gtest/gtest.h>

#include <cmath>

#include "core/subsurface/normalized_diffusion.h"
#include "testenv/support/chi_square.h"
#include "testenv/support/diffusion_profile.h"
#include "testenv/support/lone_body.h"
#include "testenv/support/z_test.h"

namespace alabaster {
namespace {

using testing::BodyInWorld;
using testing::carry;
using testing::diffusion_profile_cdf;
using testing::RunningStatistics;

constexpr float kDistance = 0.7f;

struct Channels {
  RunningStatistics value[3];
  RenderCounters counters;
};

Channels integrate(const BodyInWorld& body, const SubsurfaceEntry& entry, int samples, uint64_t seed) {
  Channels out;
  Rng rng(testing::run_seed(seed), 5);
  for (int i = 0; i < testing::run_samples(samples); ++i) {
    const auto exit = carry(NormalizedDiffusion{}, body.body(), entry, rng, out.counters);
    for (int c = 0; c < 3; ++c) out.value[c].add(exit ? exit->throughput[c] : 0);
  }
  return out;
}

void expect_channels(const Channels& found, const std::array<double, 3>& expected, double slack) {
  for (size_t c = 0; c < 3; ++c) {
    const auto result = testing::z_test(found.value[c], expected[c], {.slack = slack});
    EXPECT_TRUE(plausible(result)) << "channel " << c;
  }
}

const Rgb kSkin(0.9f, 0.6f, 0.45f), kSkinDistance(1, 0.35f, 0.2f), kThroughput(0.8f, 1, 0.3f);

WalkMedium medium_of(const Rgb& albedo, const Rgb& distance) {
  return make_medium(albedo, distance, AlbedoInversion::exact);
}

// A plane with a small quad in the middle, because rounding displaces an entry in proportion to its triangle's size.
Mesh target_mesh(float inner, float outer) {
  Mesh mesh;
  for (const float h : {inner, outer})
    for (const Vec3f& corner : {Vec3f(-1, 0, -1), Vec3f(-1, 0, 1), Vec3f(1, 0, 1), Vec3f(1, 0, -1)})
      mesh.points.push_back(corner * h);
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  for (uint32_t i = 0; i < 4; ++i) {
    const uint32_t next = (i + 1) % 4;
    mesh.triangles.push_back({i, 4 + i, 4 + next});
    mesh.triangles.push_back({i, 4 + next, next});
  }
  return mesh;
}

// Compares the radius of exits on the plane with the CDF, and their angle. All grey exits carry the same weight.
testing::SquareSampler exits_on_plane(const BodyInWorld& plane, double d, RenderCounters* counters) {
  static const WalkMedium kGrey = medium_of(Rgb(0.6f), Rgb(kDistance));
  const SubsurfaceEntry entry = plane.entry({2e-4f, 1, 1e-4f}, {0, -1, 0}, kGrey);
  return [=, &plane](Rng& rng) -> std::optional<Vec2f> {
    const auto exit = carry(NormalizedDiffusion{}, plane.body(), entry, rng, *counters);
    if (!exit) return std::nullopt;
    // Only a ball too small for floats has no axis.
    const bool unresolved = exit->throughput.r < 0.61f;
    EXPECT_NEAR(exit->throughput.r, unresolved ? 0.6 : 0.6 / kNormalAxisProbability, 1e-5);
    const Vec3f p = plane.position(exit->hit) - entry.hit.p_object;
    const double angle = std::atan2(p.z, p.x) / (2 * M_PI) + 0.5;
    return Vec2f(std::min(static_cast<float>(diffusion_profile_cdf(std::hypot(p.x, p.z), d)), kOneMinusEpsilon),
                 std::min(static_cast<float>(angle), kOneMinusEpsilon));
  };
}

TEST(DiffusionPlane, ExitsFollowTheProfile) {
  const BodyInWorld plane(target_mesh(1e-3f, 100));
  RenderCounters counters;
  const testing::SquarePdf pdf = [](const Vec2f&) { return static_cast<float>(kNormalAxisProbability); };
  const auto right = testing::chi_square_square(exits_on_plane(plane, kDistance, &counters), pdf);
  EXPECT_TRUE(plausible(right));
  EXPECT_GE(counters.probe_rays, 199990u);
  EXPECT_NEAR(static_cast<double>(counters.probe_hits), testing::run_samples(200000) * kNormalAxisProbability,
              testing::run_samples(2000));
  EXPECT_TRUE(noticed(testing::chi_square_square(exits_on_plane(plane, 1.1 * kDistance, &counters), pdf)));
}

// A spherical cap whose rim is at the chord r from its pole has the area pi r^2. So, seen from any of its points, a
// sphere equals a disk of radius 2a, and the lobe's integral over it is A CDF(2a). This covers curvature, all three
// axes, second hits and chromatic weights. The slack is the area that facets cut off.
TEST(DiffusionSphere, EnergyIsThatOfADiskOfItsDiameter) {
  constexpr int kRings = 256;
  uint64_t seed = 20;
  for (const float radius : {0.15f, 1.0f, 6.0f}) {
    const BodyInWorld sphere(testing::sphere_mesh(radius, kRings, true));
    const WalkMedium skin = medium_of(kSkin, kSkinDistance);
    SubsurfaceEntry entry = sphere.entry({7, 20, 11}, {-7, -20, -11}, skin);
    entry.throughput = kThroughput;
    const Channels found = integrate(sphere, entry, 200000, ++seed);
    std::array<double, 3> expected{};
    for (int c = 0; c < 3; ++c)
      expected[static_cast<size_t>(c)] =
          double(kSkin[c]) * kThroughput[c] * diffusion_profile_cdf(2 * radius, kSkinDistance[c]);
    expect_channels(found, expected, 3e-4);
    // At most Sum T A / min P per hit, and a line meets a sphere twice.
    const double bound = dot(Vec3f(kSkin.r, kSkin.g, kSkin.b), Vec3f(kThroughput.r, kThroughput.g, kThroughput.b));
    for (const auto& channel : found.value) EXPECT_LE(channel.max(), 2 * bound / kTangentAxisProbability);
  }
}

// The same in the whole renderer: in a constant dome a pixel shows A CDF(2a) (1 - .5 F_V)(41/42).
TEST(DiffusionSphere, FurnaceThroughTheRenderer) {
  constexpr float kScatterDistance = 0.4f;
  testing::SceneBuilder b;
  DisneyParameters p;
  p.base_color = Rgb(0.7f);
  p.roughness = 0;
  p.ior = 1;
  p.specular = 0;
  p.scatter_distance = Rgb(kScatterDistance);
  b.add(b.prototype(testing::sphere_mesh(1, 96, false)), b.material(p)).add(testing::constant_dome(1, false));
  RenderRequest request;
  request.scene = b.snapshot();
  request.camera = testing::look_at({0, 0, 4}, {0, 0, 0}, 4);  // views within 8 degrees of normal
  request.width = request.height = 32;
  request.data_window = {0, 0, 32, 32};
  request.settings.samples = 128;
  request.settings.subsurface = SubsurfaceMode::diffusion;
  RenderProgress progress;
  const auto m = testing::film_mean(*testing::render(request, &progress), 1);
  const double expected = 0.7 * diffusion_profile_cdf(2, kScatterDistance) * 41 / 42;
  EXPECT_TRUE(plausible(testing::z_test(m.mean, m.standard_error, expected, {.slack = 1e-3})));
  EXPECT_EQ(progress.counters.nonfinite_samples, 0u);
  EXPECT_GT(progress.counters.probe_hits, 0u);
  EXPECT_EQ(progress.counters.walks, 0u);
}

}  // namespace
}  // namespace alabaster
