#include "core/subsurface/normalized_diffusion.h"

#include <gtest/gtest.h>

#include <cmath>

#include "testenv/support/lone_body.h"

namespace alabaster {
namespace {

using testing::BodyInWorld;

constexpr float kInf = std::numeric_limits<float>::infinity();
const Rgb kSkin(0.9f, 0.6f, 0.45f), kSkinDistance(0.1f, 0.04f, 0.02f);

Mesh unit_ball() {
  return testing::sphere_mesh(1, 48, true);
}
SubsurfaceEntry ball_entry(const BodyInWorld& body, const WalkMedium& medium) {
  return body.entry({7, 20, 11}, {-7, -20, -11}, medium);
}
WalkMedium medium_of(const Rgb& albedo, const Rgb& distance) {
  return make_medium(albedo, distance, AlbedoInversion::exact);
}
std::optional<SubsurfaceExit> sample_exit(const BodyInWorld& body, const SubsurfaceEntry& entry, Rng& rng,
                                          RenderCounters& counters) {
  return testing::carry(NormalizedDiffusion{}, body.body(), entry, rng, counters);
}

TEST(NormalizedDiffusion, ExtremesAreFinite) {
  const BodyInWorld body(unit_ball());
  RenderCounters counters;
  Rng rng(1, 1);
  for (const float d : {1e-38f, 1e-12f, 1e-6f, 1.0f, 1e6f, 1e12f, 1e20f, 3e38f, kInf})
    for (const Rgb& distance : {Rgb(d), Rgb(d, 1, 0), Rgb(1e-3f, d, 1e3f)})
      for (const Rgb& albedo : {Rgb(0.0f), Rgb(1.0f), Rgb(0, 1, 1e-6f)})
        for (int i = 0; i < 500; ++i) {
          const WalkMedium medium = medium_of(albedo, distance);
          const auto exit = sample_exit(body, ball_entry(body, medium), rng, counters);
          if (!exit) continue;
          ASSERT_TRUE(is_finite(exit->throughput)) << d;
          EXPECT_GE(std::min(exit->throughput.r, std::min(exit->throughput.g, exit->throughput.b)), 0);
          EXPECT_LE(max_component(exit->throughput), 3 * 2 / kTangentAxisProbability);
          EXPECT_NEAR(length(exit->direction), 1, 1e-5);
          for (int c = 0; c < 3; ++c)
            if (!(albedo[c] > 0 && distance[c] > 0)) {
              EXPECT_EQ(exit->throughput[c], 0);
            }
        }
}

TEST(NormalizedDiffusion, BlackCarriesNothing) {
  const BodyInWorld body(unit_ball());
  RenderCounters counters;
  Rng rng(1, 1);
  const WalkMedium black = medium_of(Rgb(0.0f), kSkinDistance), still = medium_of(kSkin, Rgb(0.0f));
  for (int i = 0; i < 100; ++i) {
    EXPECT_FALSE(sample_exit(body, ball_entry(body, black), rng, counters));
    EXPECT_FALSE(sample_exit(body, ball_entry(body, still), rng, counters));
  }
  EXPECT_EQ(counters.probe_rays, 0u);
}

// Too small for floats to resolve: it leaves where it entered, with the whole energy and no ray.
TEST(NormalizedDiffusion, TheSmallestDistancesAreLambert) {
  const BodyInWorld body(unit_ball());
  RenderCounters counters;
  Rng rng(1, 1);
  const WalkMedium medium = medium_of(kSkin, Rgb(1e-12f));
  const SubsurfaceEntry entry = ball_entry(body, medium);
  for (int i = 0; i < 100; ++i) {
    const auto exit = sample_exit(body, entry, rng, counters);
    ASSERT_TRUE(exit);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(exit->throughput[c], kSkin[c], 1e-6);
    EXPECT_EQ(exit->hit.triangle, entry.triangle.triangle);
    EXPECT_EQ(exit->direction, entry.hit.ng);
  }
  EXPECT_EQ(counters.probe_rays, 0u);
}

// Near the limit of floats the probes still find their surface: energy is kept across it.
TEST(NormalizedDiffusion, EnergyIsKeptWhereFloatsEnd) {
  const BodyInWorld body(testing::box_mesh({1, 1, 1}));
  RenderCounters counters;
  for (const float d : {1e-7f, 1e-6f, 1e-5f, 1e-4f, 1e-3f}) {
    Rng rng(2, 2);
    const WalkMedium white = medium_of(Rgb(1), Rgb(d));
    double sum = 0;
    constexpr int kSamples = 40000;
    for (int i = 0; i < kSamples; ++i)
      if (const auto exit = sample_exit(body, body.entry({0.31f, 5, 0.17f}, {0, -1, 0}, white), rng, counters))
        sum += exit->throughput.r;
    // Either axis or none: variance at most 1.
    EXPECT_NEAR(sum / kSamples, 1, 4 / std::sqrt(double(kSamples))) << d;
  }
}

// Faces that a file holds twice are one surface.
TEST(NormalizedDiffusion, CoincidentFacesAreOne) {
  Mesh mesh = testing::box_mesh({1, 1, 1});
  const BodyInWorld once(mesh);
  mesh.triangles.insert(mesh.triangles.end(), mesh.triangles.begin(), mesh.triangles.end());
  mesh.triangle_face.clear();  // each triangle is its own face
  const BodyInWorld twice(mesh);
  const WalkMedium skin = medium_of(kSkin, kSkinDistance);
  RenderCounters counters;
  for (uint64_t i = 0; i < 5000; ++i) {
    Rng rng_a(i, 3), rng_b(i, 3);
    const Vec3f eye(0.9f, 5, 0.2f), down(0, -1, 0);
    const auto a = sample_exit(once, once.entry(eye, down, skin), rng_a, counters);
    const auto b = sample_exit(twice, twice.entry(eye, down, skin), rng_b, counters);
    ASSERT_EQ(a.has_value(), b.has_value());
    if (a) {
      EXPECT_EQ(a->throughput, b->throughput);
    }
  }
}

// Light leaves a closed body outward, wherever it was seen from; a plane on the side that it was entered from.
TEST(NormalizedDiffusion, ExitsLeaveTheBody) {
  const BodyInWorld box(testing::box_mesh({1, 1, 1})), plane(testing::plane_mesh(4));
  const WalkMedium skin = medium_of(kSkin, kSkinDistance);
  RenderCounters counters;
  Rng rng(3, 3);
  const SubsurfaceEntry outside = box.entry({0.3f, 5, 0.2f}, {0, -1, 0}, skin);
  const SubsurfaceEntry inside = box.entry({0.3f, 0, 0.2f}, {0, 1, 0}, skin);
  const SubsurfaceEntry above = plane.entry({0.3f, 5, 0.2f}, {0, -1, 0}, skin);
  const SubsurfaceEntry below = plane.entry({0.3f, -5, 0.2f}, {0, 1, 0}, skin);
  for (int i = 0; i < 100; ++i) {
    for (const SubsurfaceEntry& entry : {outside, inside})
      if (const auto exit = sample_exit(box, entry, rng, counters)) {
        EXPECT_GT(dot(exit->direction, box.position(exit->hit)), 0);
      }
    if (const auto exit = sample_exit(plane, above, rng, counters)) {
      EXPECT_GT(exit->direction.y, 0);
    }
    if (const auto exit = sample_exit(plane, below, rng, counters)) {
      EXPECT_LT(exit->direction.y, 0);
    }
  }
}

// The same ellipsoid twice: as a mesh, and as a sphere under a stretching, mirroring transform.
TEST(NormalizedDiffusion, DistancesAreWorldDistancesUnderNonUniformScale) {
  const Vec3f scale(2, -0.5f, 5);
  Mesh mesh = testing::sphere_mesh(1, 48, false);
  const BodyInWorld instance(mesh, Matrix4d().setScale(Vec3d(scale)));
  for (Vec3f& p : mesh.points) p *= scale;
  const BodyInWorld scaled(mesh);
  const Vec3f eye(7, 20, 11);
  const WalkMedium skin = medium_of(kSkin, Rgb(0.5f, 0.2f, 0.1f));
  const SubsurfaceEntry a = instance.entry(eye, -eye, skin);
  const SubsurfaceEntry b = scaled.entry(eye, -eye, skin);
  ASSERT_EQ(a.triangle.triangle, b.triangle.triangle);
  EXPECT_LT(length(a.hit.ng - b.hit.ng), 1e-5);
  RenderCounters counters;
  int different = 0, exits = 0;
  for (uint64_t i = 0; i < 20000; ++i) {
    Rng rng_a(i, 3), rng_b(i, 3);
    const auto exit_a = sample_exit(instance, a, rng_a, counters), exit_b = sample_exit(scaled, b, rng_b, counters);
    if (exit_a.has_value() != exit_b.has_value() || (exit_a && exit_a->hit.triangle != exit_b->hit.triangle)) {
      ++different;  // decided by rounding at an edge
      continue;
    }
    if (!exit_a) continue;
    ++exits;
    EXPECT_LT(length(instance.position(exit_a->hit) - scaled.position(exit_b->hit)), 1e-4);
    EXPECT_LT(length(exit_a->direction - exit_b->direction), 1e-4);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(exit_a->throughput[c], exit_b->throughput[c], 1e-3);
  }
  EXPECT_LE(different, 20);
  EXPECT_GT(exits, 8000);
}

}  // namespace
}  // namespace alabaster
