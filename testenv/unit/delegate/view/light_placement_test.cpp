// Lights that follow a mouse.
#include "delegate/view/light_placement.h"

#include <gtest/gtest.h>

namespace alabaster::view {
namespace {

using hd::Matrix4d;
using hd::Vec3d;

Vec3d axis_of(const Matrix4d& m, int i) {
  return {m[i][0], m[i][1], m[i][2]};
}

TEST(LightPlacement, AnAimedLightKeepsItsPlaceAndSizeAndStandsLevel) {
  const Matrix4d light = Matrix4d().setScale(Vec3d(2, 3, 0.5)) * Matrix4d().setTranslation(Vec3d(1, 4, 2));
  for (const Vec3d& target : {Vec3d(0, 0, 0), Vec3d(1, 0, 2), Vec3d(1, 9, 2), Vec3d(-5, 4, 2)})
    for (const Vec3d& up : {Vec3d(0, 1, 0), Vec3d(0, 0, 1)}) {
      const Matrix4d m = aimed(light, target, up);
      EXPECT_EQ(m.translation(), light.translation());
      EXPECT_LT((axis_of(m, 2).normalized() + (target - light.translation()).normalized()).length(), 1e-12);
      EXPECT_NEAR(axis_of(m, 0).length(), 2, 1e-12);
      EXPECT_NEAR(axis_of(m, 1).length(), 3, 1e-12);
      EXPECT_NEAR(axis_of(m, 2).length(), 0.5, 1e-12);
      EXPECT_NEAR(axis_of(m, 0).dot(up), 0, 1e-12) << "level";
      EXPECT_GE(axis_of(m, 1).dot(up), -1e-12) << "upright";
      EXPECT_NEAR(m.determinant(), light.determinant(), 1e-9);
    }
  EXPECT_EQ(aimed(light, light.translation(), Vec3d(0, 1, 0)), light) << "it is there";
  const Matrix4d image = Matrix4d().setScale(Vec3d(-1, 1, 1)) * light;
  EXPECT_NEAR(aimed(image, Vec3d(0), Vec3d(0, 1, 0)).determinant(), -3, 1e-9) << "its image stays mirrored";
}

TEST(LightPlacement, AHighlightObeysTheLawOfReflection) {
  const SurfacePoint surface{Vec3d(1, 2, 3), Vec3d(1, 1, 0).normalized()};
  const Vec3d to_eye = Vec3d(0.2, 0.9, 0.4).normalized(), up(0, 1, 0);
  const Matrix4d m = mirrored(Matrix4d(), surface, to_eye, 7, up);
  const Vec3d way = m.translation() - surface.point;
  EXPECT_NEAR(way.length(), 7, 1e-12);
  const Vec3d half = (way.normalized() + to_eye).normalized();
  EXPECT_LT((half - surface.normal).length(), 1e-12);
  EXPECT_LT((axis_of(m, 2) - way.normalized()).length(), 1e-12) << "it shines at the point";
}

TEST(LightPlacement, ToolsAreThoseThatMakeADifference) {
  for (const LightTool tool : {LightTool::move, LightTool::aim, LightTool::highlight}) {
    EXPECT_TRUE(can_use(tool, "rectLight"));
    EXPECT_FALSE(can_use(tool, "domeLight"));
    EXPECT_EQ(can_use(tool, "distantLight"), tool == LightTool::highlight);
  }
  EXPECT_TRUE(can_use(LightTool::none, "domeLight"));
}

}  // namespace
}  // namespace alabaster::view
