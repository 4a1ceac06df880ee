#include "delegate/support/instancing.h"

#include <gtest/gtest.h>

#include "delegate/host/retained_scene_delegate.h"

namespace alabaster::hd::support {
namespace {

// A million points must cost neither a copy nor a matrix each.
TEST(InstancePlacement, PointsStayInTheHostsArrays) {
  const auto own = std::make_shared<const std::vector<Vec3f>>(std::vector<Vec3f>{{1, 2, 3}, {4, 5, 6}});
  host::InstancerDescription instancer;
  instancer.primvars["hydra:instanceTranslations"] = Array<Vec3f>(own, own->data(), own->size());
  instancer.primvars["hydra:instanceScales"] = Array<Vec3f>{{2, 2, 2}};
  host::RetainedSceneDelegate scene;
  scene.SetInstancer("/i", instancer);
  int reports = 0;
  const InstancePoints points = pull_instance_points(
      scene, "/i", [&](const char* code, const Path&, const std::string&) { reports += code != nullptr; });
  ASSERT_TRUE(points);
  EXPECT_EQ(points->translations.data(), own->data());
  ASSERT_EQ(points->size(), 2u);
  EXPECT_EQ(reports, 1) << "one array is shorter";
  EXPECT_EQ(Vec3d(1, 1, 1) * (*points)[0], Vec3d(3, 4, 5));
  EXPECT_EQ(Vec3d(1, 1, 1) * (*points)[1], Vec3d(5, 6, 7)) << "identity beyond the end of the scales";
}

}  // namespace
}  // namespace alabaster::hd::support
