#include "core/integrator/direct_light.h"

#include <gtest/gtest.h>

#include <cmath>

#include "testenv/support/path_tracer.h"

namespace alabaster {
namespace {

/// Sum over the lights that arrive.
template <class Scatter>
Rgb direct_light(const PathContext& context, const Departure& from, const std::array<float, 4>& u,
                 const Scatter& scatter) {
  Rgb sum(0.0f);
  for_direct_light(context, from, {context.scene.lights, u, ConstantDomes::sampled, nullptr}, scatter,
                   [&](const ScatterValue&, const Rgb& light, LightWeight) { sum += light; });
  return sum;
}

using testing::PathTracer;
using testing::SceneBuilder;

/// A sun without extent that shines from `degrees` off the y axis, towards +x, and gives 3 on a facing plane.
LightParameters sun(double degrees) {
  LightParameters light;
  light.type = LightType::distant;
  light.angle = 0;
  light.intensity = 3;
  light.light_to_world.setAxisAngle(Vec3d(0, 0, 1), -degrees * M_PI / 180);
  light.light_to_world = Matrix4d().setAxisAngle(Vec3d(1, 0, 0), -M_PI / 2) * light.light_to_world;
  return light;
}

constexpr std::array<float, 4> kNumbers = {0.5f, 0.5f, 0.5f, 0.5f};
const auto kConstant = [](const Vec3f&) { return ScatterValue{Rgb(0.5f), 1}; };

// E c / pi (1 - .5 F_L) (1 - .5 F_V) cos, exactly: one light without extent has no noise.
TEST(DirectLight, DistantLightOnAMattPlaneIsAnalytic) {
  for (const double degrees : {0.0, 40.0, 75.0}) {
    SceneBuilder b;
    b.add(b.prototype(testing::plane_mesh(2)), b.material(testing::matt({0.8f, 0.4f, 0.2f}))).add(sun(degrees));
    PathTracer tracer(b.snapshot(), {0, 3, 0});
    tracer.settings.max_depth = 2;
    const double cosine = std::cos(degrees * M_PI / 180);
    const double expected = 3 / M_PI * (1 - 0.5 * std::pow(1 - cosine, 5)) * cosine;
    for (uint32_t i = 0; i < 8; ++i) {
      const Rgb color = tracer.trace(i).color;
      EXPECT_NEAR(color.r / (0.8 * expected), 1, 2e-6) << degrees;
      EXPECT_NEAR(color.b / (0.2 * expected), 1, 2e-6) << degrees;
    }
    EXPECT_EQ(tracer.counters.shadow_rays, 8u);
  }
}

TEST(DirectLight, OccludedIsBlackAndUnscatteredLightTracesNoRay) {
  SceneBuilder b;
  b.add(b.prototype(testing::plane_mesh(1)), b.material({}), Matrix4d().setTranslation(Vec3d(0, 1, 0))).add(sun(0));
  PathTracer tracer(b.snapshot(), {0, 3, 0});
  const Vec3f origin(tracer.context().scene.origin);
  const auto lit_at = [&](const Vec3f& p, const auto& scatter) {
    Departure from;
    from.flat = from.curved = p - origin;
    from.ng = {0, 1, 0};
    return direct_light(tracer.context(), from, kNumbers, scatter);
  };
  EXPECT_EQ(lit_at({0, 0, 0}, kConstant), Rgb(0.0f)) << "under the plane";
  EXPECT_EQ(lit_at({0.6f, 0, 0}, kConstant), Rgb(1.5f)) << "beside it";
  EXPECT_EQ(lit_at({0, 2, 0}, kConstant), Rgb(1.5f)) << "over it";
  EXPECT_EQ(tracer.counters.shadow_rays, 3u);
  EXPECT_EQ(lit_at({0, 2, 0}, [](const Vec3f&) { return ScatterValue{Rgb(0.0f), 1}; }), Rgb(0.0f));
  EXPECT_EQ(tracer.counters.shadow_rays, 3u);
}

// A light with extent is weighed against the lobe by the power heuristic, one without is not.
TEST(DirectLight, IsWeighedByThePowerHeuristic) {
  LightParameters disk = sun(0);
  disk.angle = 10;
  SceneBuilder b;
  b.add(disk);
  PathTracer tracer(b.snapshot(), {0, 3, 0});
  const float cone = 2 * kPi * (1 - std::cos(5 * kPi / 180)), light_pdf = 1 / cone;
  for (const float pdf : {0.0f, 0.5f * light_pdf, 10 * light_pdf}) {
    Departure from;
    from.flat = from.curved = {0, 0, 0};
    from.ng = {0, 1, 0};
    const Rgb light = direct_light(tracer.context(), from, kNumbers, [&](const Vec3f&) {
      return ScatterValue{Rgb(0.5f), pdf};
    });
    const float weight = light_pdf * light_pdf / (light_pdf * light_pdf + pdf * pdf);
    EXPECT_NEAR(light.g / (1.5f * cone * weight), 1, 1e-4f) << pdf;
  }
}

// A facet that lies flat, with a lobe that leans over its edge: light from below its horizon leaves from the curved
// surface, with the chance that the wedge gives it, and only if nothing lies between the two.
TEST(DirectLight, ShadowRayBelowTheFacetStartsAtTheCurvedSurface) {
  for (const bool blocked : {false, true}) {
    SceneBuilder b;
    b.add(sun(100));
    if (blocked)
      b.add(b.prototype(testing::plane_mesh(1)), b.material({}), Matrix4d().setTranslation(Vec3d(0, 0.05, 0)));
    PathTracer tracer(b.snapshot(), {0, 3, 0});
    const Vec3f origin(tracer.context().scene.origin);
    Departure from;
    from.flat = Vec3f(0, 0, 0) - origin;
    from.curved = Vec3f(0, 0.1f, 0) - origin;
    from.ng = {0, 1, 0};
    from.wedge = 1.0f / 32;
    double sum = 0;
    for (int i = 0; i < 64; ++i) {
      const std::array<float, 4> u = {0.5f, 0.5f, 0.5f, (static_cast<float>(i) + 0.5f) / 64};
      sum += direct_light(tracer.context(), from, u, kConstant).g / 64;
    }
    EXPECT_NEAR(sum, blocked ? 0 : 1.5, 1e-6);
    EXPECT_EQ(tracer.counters.shadow_rays, blocked ? 16u : 32u)
        << "a quarter of the numbers, each with one or two rays";
    const Vec3f up(0, 1, 0), down = normalize(Vec3f(1, -0.1f, 0));
    EXPECT_EQ(origin_of(tracer.context(), from, up), from.flat);
    EXPECT_EQ(origin_of(tracer.context(), from, down), blocked ? from.flat : from.curved);
  }
}

}  // namespace
}  // namespace alabaster
