#include "core/integrator/shading_normal.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/integrator/path_state.h"
#include "core/sampling/pixel_sampler.h"
#include "core/sampling/warp.h"
#include "testenv/support/memory_texture.h"
#include "testenv/support/scene_builder.h"

namespace alabaster {
namespace {

// A square in the xz plane, normal +y, u along x and v along -z, with a normal map of one value.
class MappedPlane {
 public:
  explicit MappedPlane(const Rgb& normal, const Matrix4d& transform = Matrix4d(), bool mirrored_uv = false) {
    testing::SceneBuilder b;
    Mesh mesh = testing::plane_mesh(2);
    mesh.uv_sets.push_back({{}, "st"});
    for (const Vec3f& p : mesh.points) mesh.uv_sets[0].values.emplace_back(mirrored_uv ? -p.x : p.x, -p.z);
    auto material = std::make_shared<DisneyMaterial>();
    material->normal_map = TextureLookup();
    material->normal_map->image = std::make_shared<testing::MemoryTexture>(1, std::vector<Rgb>{normal});
    b.add(b.prototype(std::move(mesh)), material, transform);
    snapshot_ = b.snapshot();
  }

  Vec3f from(const Vec3f& side) const {
    const Instance& instance = snapshot_->instances[0];
    TriangleHit hit;
    hit.u = hit.v = 0.25f;
    const SurfaceHit at = surface_on_side(instance, instance, hit, side);
    return mapped_normal(instance, instance, hit, at, *instance.material(0).normal_map);
  }

 private:
  std::shared_ptr<const SceneSnapshot> snapshot_;
};

void expect_near(const Vec3f& a, const Vec3f& b) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], 1e-6f) << i;
}

TEST(MappedNormal, TiltsAlongUAndV) {
  expect_near(MappedPlane({0.6f, 0, 0.8f}).from({0, 1, 0}), {0.6f, 0.8f, 0});
  expect_near(MappedPlane({0, 0.6f, 0.8f}).from({0, 1, 0}), {0, 0.8f, -0.6f});
  expect_near(MappedPlane({0, 0, 5}).from({0, 1, 0}), {0, 1, 0});
}

TEST(MappedNormal, IsOneReliefSeenFromBothSides) {
  expect_near(MappedPlane({0.6f, 0, 0.8f}).from({0, -1, 0}), {-0.6f, -0.8f, 0});
}

TEST(MappedNormal, FollowsMirroredCoordinatesAndTransforms) {
  // u runs along -x, v as before: red tilts towards -x, green as it did.
  expect_near(MappedPlane({0.6f, 0, 0.8f}, {}, true).from({0, 1, 0}), {-0.6f, 0.8f, 0});
  expect_near(MappedPlane({0, 0.6f, 0.8f}, {}, true).from({0, 1, 0}), {0, 0.8f, -0.6f});
  // The picture in a mirror is the mirror image of the picture.
  const Matrix4d mirror = Matrix4d().setScale(Vec3d(1, 1, -1));
  expect_near(MappedPlane({0.6f, 0, 0.8f}, mirror).from({0, 1, 0}), {0.6f, 0.8f, 0});
  expect_near(MappedPlane({0, 0.6f, 0.8f}, mirror).from({0, 1, 0}), {0, 0.8f, 0.6f});
}

TEST(MappedNormal, IsTheSurfacesWhereTheMapSaysNothing) {
  expect_near(MappedPlane(Rgb(0.0f)).from({0, 1, 0}), {0, 1, 0});
  expect_near(MappedPlane(Rgb(std::numeric_limits<float>::quiet_NaN())).from({0, 1, 0}), {0, 1, 0});
}

TEST(ReflectingNormal, KeepsTheMirrorImageAboveTheSurface) {
  const Vec3f surface(0, 0, 1);
  Rng rng(1, 2);
  for (int i = 0; i < 20000; ++i) {
    const Vec3f wo = sample_cosine_hemisphere({rng.uniform(), rng.uniform()});
    const Vec3f n = sample_cosine_hemisphere({rng.uniform(), rng.uniform()});
    if (wo.z < 1e-4f) continue;
    const Vec3f bent = reflecting_normal(n, surface, wo);
    EXPECT_NEAR(length(bent), 1, 1e-5f);
    EXPECT_GT(dot(bent, wo), 0);
    const Vec3f mirrored = bent * (2 * dot(bent, wo)) - wo;
    EXPECT_GT(mirrored.z, 0) << wo.z << " " << n.x << " " << n.y << " " << n.z;
    const Vec3f straight = n * (2 * dot(n, wo)) - wo;
    if (straight.z > 0.01f && dot(n, wo) > 0) {
      EXPECT_EQ(bent, n);
    }
  }
}

}  // namespace
}  // namespace alabaster
