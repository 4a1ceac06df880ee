#include "core/integrator/vertex.h"

#include <gtest/gtest.h>

#include <ImathMatrixAlgo.h>

#include <cmath>

#include "testenv/support/path_tracer.h"

namespace alabaster {
namespace {

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

// Light from below the horizon of a facet, but not of its smooth normal, leaves from the curved surface over it, with
// the chance that the wedge gives it.
TEST(DirectLight, BelowTheFacetItLeavesFromTheSmoothSurface) {
  SceneBuilder b;
  b.add(b.prototype(testing::sphere_mesh(1, 24, true)), b.material(testing::matt(Rgb(0.5f))));
  const Vec3d eye(0.23, 0.31, 4);
  PathTracer bare(b.snapshot(), eye);
  const PathContext context = bare.context();
  const Ray ray{Vec3f(eye - context.scene.origin), normalize(Vec3f(-eye))};
  TriangleHit hit;
  ASSERT_TRUE(context.scene.top->intersect(ray, &hit));
  Vertex v;
  evaluate_surface(context, ray, hit, 0, &v);
  const float chance = v.origins[Vertex::kSmooth].chance;
  ASSERT_GT(chance, 0.05f);
  ASSERT_LT(chance, 0.9f);

  // In the middle of the wedge.
  const Vec3f across = normalize(v.smooth_normal() - v.hit.ng * dot(v.smooth_normal(), v.hit.ng));
  const float wedge = std::asin(length(cross(v.hit.ng, v.smooth_normal())));
  const Vec3f towards = across * std::cos(wedge / 2) - v.hit.ng * std::sin(wedge / 2);
  LightParameters light = sun(0);
  light.light_to_world = Imath::rotationMatrix(Vec3d(0, 0, 1), Vec3d(towards));
  b.add(light);
  PathTracer tracer(b.snapshot(), eye);
  tracer.settings.max_depth = 1;
  double sum = 0;
  for (uint32_t i = 0; i < 1024; ++i) sum += double(tracer.trace(i).color.g) / 1024;
  const double cosine = std::sin(wedge / 2), from = double(dot(v.smooth_normal(), -ray.dir));
  const double expected =
      0.5 * 3 / M_PI * (1 - 0.5 * std::pow(1 - cosine, 5)) * (1 - 0.5 * std::pow(1 - from, 5)) * cosine;
  EXPECT_NEAR(sum, expected, 0.01 * expected);
  EXPECT_NEAR(double(tracer.counters.shadow_rays) / 1024, 2 * double(chance), 0.01);
}

}  // namespace
}  // namespace alabaster
