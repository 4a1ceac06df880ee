#include "core/integrator/shading_normal.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/integrator/vertex.h"
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
    material->normal_map.emplace();
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

// Each turns its image by another angle, and so has tangents of its own.
TEST(MappedNormal, TurnsWithEachOfManyMapsOfOneMesh) {
  testing::SceneBuilder b;
  Mesh mesh = testing::plane_mesh(2);
  mesh.uv_sets.push_back({{}, "st"});
  for (const Vec3f& p : mesh.points) mesh.uv_sets[0].values.emplace_back(p.x, -p.z);
  b.add(b.prototype(std::move(mesh)), b.material({}));
  auto& materials = b.description.instances[0].materials;
  for (int i = 0; i < 40; ++i) {
    auto material = std::make_shared<DisneyMaterial>();
    material->normal_map.emplace();
    material->normal_map->image = std::make_shared<testing::MemoryTexture>(1, std::vector<Rgb>{{0.6f, 0, 0.8f}});
    material->normal_map->transform = UvTransform({0, 0}, 0.15f * static_cast<float>(i), {1, 1});
    materials.push_back(material);
    if (i % 4 == 0) materials.push_back(material);  // in another slot
  }
  const auto snapshot = b.snapshot();
  const Instance& instance = snapshot->instances[0];
  TriangleHit hit;
  hit.u = hit.v = 0.25f;
  const SurfaceHit at = surface_on_side(instance, instance, hit, {0, 1, 0});
  for (size_t slot = 1; slot < materials.size(); ++slot) {
    const NormalMap& map = *materials[slot]->normal_map;
    const auto own = instance.prototype->tangents.of(instance.prototype->mesh, map.primvar, map.transform.axes());
    const Vec4f& along = own->values[0];
    expect_near(mapped_normal(instance, instance, hit, at, map), {0.6f * along.x, 0.8f, 0.6f * along.z});
  }
}

TEST(MappedNormal, IsTheSurfacesWhereTheMapSaysNothing) {
  expect_near(MappedPlane(Rgb(0.0f)).from({0, 1, 0}), {0, 1, 0});
  expect_near(MappedPlane(Rgb(std::numeric_limits<float>::quiet_NaN())).from({0, 1, 0}), {0, 1, 0});
}

// z = a sin(k u) cos(k v) as texels: the tilt of a bump map is that of the normal map derived from the same heights.
TEST(BumpMap, TiltsAsTheNormalMapOfItsHeights) {
  constexpr int kSize = 128;
  constexpr float kPeriods = kTwoPi * 3, kHeight = 0.02f, kWidth = 2;  // of the plane, which has the square once
  std::vector<Rgb> heights, normals;
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      const float u = (static_cast<float>(x) + 0.5f) / kSize, v = 1 - (static_cast<float>(y) + 0.5f) / kSize;
      const auto s = kPeriods * u, t = kPeriods * v;
      heights.emplace_back(0.5f, 0.5f + 0.5f * std::sin(s) * std::cos(t), 0.0f);
      const float slope = kHeight * 0.5f * kPeriods / kWidth;
      normals.emplace_back(-slope * std::cos(s) * std::cos(t), slope * std::sin(s) * std::sin(t), 1.0f);
    }
  const auto plane = [&](std::vector<Rgb> texels, bool bump, const Matrix4d& transform) {
    testing::SceneBuilder b;
    Mesh mesh = testing::plane_mesh(kWidth);
    mesh.uv_sets.push_back({{}, "st"});
    for (const Vec3f& p : mesh.points) mesh.uv_sets[0].values.emplace_back(p.x / kWidth, -p.z / kWidth);
    auto material = std::make_shared<DisneyMaterial>();
    material->normal_map.emplace();
    material->normal_map->image = std::make_shared<testing::MemoryTexture>(kSize, std::move(texels));
    material->normal_map->is_bump = bump;
    material->normal_map->channel = Channel::g;
    if (bump) material->normal_map->scale = Rgb(kHeight);
    b.add(b.prototype(std::move(mesh)), material, transform);
    return b.snapshot();
  };
  const auto normal_at = [](const SceneSnapshot& scene, uint32_t triangle, const Vec2f& at, const Vec3f& side) {
    TriangleHit hit;
    hit.triangle = triangle, hit.u = at.x, hit.v = at.y;
    const Instance& instance = scene.instances[0];
    return mapped_normal(instance, instance, hit, surface_on_side(instance, instance, hit, side),
                         *instance.material(0).normal_map);
  };
  Rng rng(4, 5);
  // Relief grows with its object, so that turning and scaling alike change nothing; mirrors mirror.
  for (const Matrix4d& m : {Matrix4d(), Matrix4d().setScale(3.0), Matrix4d().setScale(Vec3d(1, 1, -1))}) {
    const auto bump = plane(heights, true, m), map = plane(normals, false, m);
    float steepest = 0;
    for (int i = 0; i < 2000; ++i) {
      const float u = rng.uniform(), v = (1 - u) * rng.uniform();
      const Vec3f side(0, i % 2 ? 1.0f : -1.0f, 0);
      const Vec3f a = normal_at(*bump, uint32_t(i % 4 / 2), {u, v}, side),
                  b = normal_at(*map, uint32_t(i % 4 / 2), {u, v}, side);
      EXPECT_LT(length(a - b), 2e-3f);
      EXPECT_GT(dot(a, side), 0);
      steepest = std::max(steepest, std::abs(a.x));
    }
    EXPECT_GT(steepest, 0.08f);
  }
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
