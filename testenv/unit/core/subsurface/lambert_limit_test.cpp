#include "core/subsurface/lambert_limit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/material/disney_bsdf.h"
#include "testenv/support/analytic_bodies.h"
#include "testenv/support/half_space.h"
#include "testenv/support/scene_builder.h"
#include "testenv/support/transport_solution.h"

namespace alabaster {
namespace {

constexpr float kAlbedos[] = {0.05f, 0.2f, 0.5f, 0.8f, 0.95f, 0.99f};

LightReach grey_reach(float albedo) {
  return light_reach(make_medium(Rgb(albedo, 0, 0), Rgb(1, 0, 0), AlbedoInversion::exact));
}

TEST(LambertLimit, TheBlendMovesAtMostTheTolerance) {
  const LightReach reach{2.5f, 0};
  float last = 0;
  for (float width = 1; width < 1e4f; width *= 1.01f) {
    const float p = lambert_probability(width, reach);
    EXPECT_GE(p, last);
    EXPECT_LE(p * reach.exit_radius / (M_PI * width), kLambertTolerance);
    last = p;
  }
  EXPECT_EQ(last, 1);
  EXPECT_EQ(lambert_probability(24 * reach.exit_radius, reach), 0);
  EXPECT_EQ(lambert_probability(0, reach), 0);
}

TEST(LambertLimit, TheFarthestReachingChannelDecides) {
  const Rgb albedo(0.9f, 0.6f, 0.45f);
  const LightReach all = light_reach(make_medium(albedo, {1, 0.3f, 0.2f}, AlbedoInversion::exact));
  const LightReach red = light_reach(make_medium(albedo, {1, 0, 0}, AlbedoInversion::exact));
  EXPECT_EQ(all.exit_radius, red.exit_radius);
  EXPECT_EQ(all.opaque_depth, red.opaque_depth);
  EXPECT_NEAR(red.exit_radius, 3.3f, 0.3f);
}

TEST(LambertLimit, WhiteIsAlwaysWalked) {
  EXPECT_EQ(lambert_probability(1e30f, grey_reach(1)), 0);
  EXPECT_FALSE(std::isnan(lambert_probability(1e30f, grey_reach(0))));
}

// Keeps the place beside the depth, which the half-space alone does not need.
class LateralTracer : public testing::SlabTracer {
 public:
  bool advance(const Vec3f& direction, float t) {
    moved_ += testing::to_double(direction) * t;
    return SlabTracer::advance(direction, t);
  }
  double exit_distance(const Hit& hit) const { return hit.t; }
  Vec3d moved() const { return moved_; }

 private:
  Vec3d moved_{0, 0, 0};
};

TEST(LambertLimit, ReachIsTheMeanExitRadius) {
  for (const float albedo : {0.2f, 0.5f, 0.8f, 0.95f}) {
    const Medium medium = make_medium(Rgb(albedo, 0, 0), Rgb(1, 0, 0), AlbedoInversion::exact);
    Rng rng(7, 7);
    RenderCounters counters;
    double radii = 0, exits = 0;
    for (int i = 0; i < 30000; ++i) {
      LateralTracer tracer;
      const auto end = testing::walk_body(tracer, medium, {}, rng, counters);
      if (!end) continue;
      const Vec3d p = tracer.moved() + testing::to_double(end->direction) * end->hit.t;
      radii += end->throughput[0] * std::hypot(p.x, p.y);
      exits += end->throughput[0];
    }
    EXPECT_NEAR(grey_reach(albedo).exit_radius / (radii / exits), 1.05, 0.1) << albedo;
  }
}

TEST(LambertLimit, AnOpaqueSlabLetsTheToleranceThrough) {
  for (const float albedo : kAlbedos) {
    const Medium medium = make_medium(Rgb(albedo, 0, 0), Rgb(1, 0, 0), AlbedoInversion::exact);
    const double depth = double(grey_reach(albedo).opaque_depth) * medium.sigma_t.r;
    if (depth > 60) continue;  // beyond what the quadrature resolves
    const testing::SlabAnswer slab = testing::solve_slab(depth, medium.one_minus_alpha.r);
    EXPECT_LT(slab.transmittance, kLambertTolerance) << albedo;
    EXPECT_NEAR(slab.reflectance, albedo, kLambertTolerance) << albedo;
  }
}

TEST(LambertLimit, ObtainedAlbedoIsTheHalfSpaces) {
  for (const AlbedoInversion inversion :
       {AlbedoInversion::exact, AlbedoInversion::chiang2016, AlbedoInversion::van_de_hulst})
    for (const float albedo : {0.0f, 0.01f, 0.2f, 0.5f, 0.8f, 0.95f, 0.999f, 1.0f})
      EXPECT_NEAR(obtained_albedo(albedo, inversion), testing::half_space_albedo(one_minus_alpha(albedo, inversion)),
                  1e-6)
          << albedo;
}

// A channel without scatterDistance is the 2015 diffuse to the bit, whatever the others do: the random choices of a
// render are theirs, the lobe's value is not.
TEST(LambertLimit, ChannelsWithoutDistanceAreTheDiffuseBitForBit) {
  DisneyParameters mixed, plain;
  mixed.base_color = plain.base_color = {0.9f, 0.6f, 0.45f};
  mixed.scatter_distance = {0.1f, 0, 0.3f};
  Rng rng(3, 3);
  for (int i = 0; i < 1000; ++i) {
    const Vec3f wo = sample_cosine_hemisphere({rng.uniform(), rng.uniform()});
    const Vec3f wi = sample_cosine_hemisphere({rng.uniform(), rng.uniform()});
    const DisneyBsdf a(mixed, wo), b(plain, wo);
    EXPECT_EQ(a.evaluate(wi).f.g, b.evaluate(wi).f.g);
    EXPECT_EQ(a.subsurface_entry().g, 0);
  }
}

RenderRequest scene_at(testing::SceneBuilder* b, double scale, const Rgb& distance, double eye) {
  DisneyParameters p;
  p.base_color = {0.9f, 0.6f, 0.45f};
  p.scatter_distance = distance * static_cast<float>(scale);
  b->add(b->prototype(testing::sphere_mesh(static_cast<float>(scale), 24, true)), b->material(p));
  LightDescription key;
  key.type = LightType::sphere;
  key.radius = static_cast<float>(0.25 * scale);
  key.intensity = 30;
  key.light_to_world.setTranslation(Vec3d(2, 3, 1) * scale);
  b->add(key).add(testing::constant_dome(0.2f, true));
  RenderRequest request;
  request.scene = b->snapshot();
  request.camera = testing::look_at(Vec3d(0, 0.25 * eye, eye) * scale, {0, 0, 0}, 40);
  request.width = request.height = 24;
  request.data_window = {0, 0, 24, 24};
  request.settings.samples = 4;
  request.settings.subsurface = SubsurfaceMode::automatic;
  return request;
}

std::vector<float> pixels(const RenderRequest& request, RenderProgress* progress = nullptr) {
  return testing::render(request, progress)->resolve_float(Aov::color);
}

// Half of the footprints here lie in the blend.
const Rgb kBlended(0.0004f, 0.0002f, 0.0001f);

TEST(AutomaticMode, PowersOfTwoAndThreadsChangeNothing) {
  testing::SceneBuilder b;
  RenderRequest request = scene_at(&b, 1, kBlended, 4);
  request.settings.threads = 1;
  RenderProgress progress;
  const auto expected = pixels(request, &progress);
  EXPECT_GT(progress.counters.lambert_exits, 100u);
  EXPECT_GT(progress.counters.walks, 50u);
  request.settings.threads = 3;
  EXPECT_EQ(pixels(request), expected);
  for (const int exponent : {-20, 7}) {
    testing::SceneBuilder other;
    EXPECT_EQ(pixels(scene_at(&other, std::ldexp(1.0, exponent), kBlended, 4)), expected) << "2^" << exponent;
  }
}

TEST(AutomaticMode, WithoutDistanceItIsTheDiffuseBitForBit) {
  testing::SceneBuilder b;
  RenderRequest request = scene_at(&b, 1, Rgb(0.0f), 4);
  const auto automatic = pixels(request);
  request.settings.subsurface = SubsurfaceMode::lambert;
  EXPECT_EQ(pixels(request), automatic);
}

// Nearby, every camera sample is walked: with direct light alone not a bit differs.
TEST(AutomaticMode, NearbyItIsTheWalkBitForBit) {
  testing::SceneBuilder b;
  RenderRequest request = scene_at(&b, 1, Rgb(0.1f, 0.05f, 0.02f), 4);
  request.settings.max_depth = 1;
  const auto automatic = pixels(request);
  request.settings.subsurface = SubsurfaceMode::walk;
  EXPECT_EQ(pixels(request), automatic);
}

TEST(AutomaticMode, FromAfarASolidBodyIsNotWalked) {
  testing::SceneBuilder b;
  RenderProgress progress;
  pixels(scene_at(&b, 1, Rgb(5e-5f), 4), &progress);
  EXPECT_GT(progress.counters.lambert_exits, 0u);
  EXPECT_GT(progress.counters.lambert_exits, 100 * progress.counters.walks);
}

}  // namespace
}  // namespace alabaster
