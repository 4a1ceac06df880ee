#include "core/scene/scene.h"

#include <gtest/gtest.h>

#include <limits>

#include "testenv/support/cages.h"
#include "testenv/support/material_testing.h"
#include "testenv/support/memory_texture.h"
#include "testenv/support/scene_builder.h"

namespace alabaster {
namespace {

Matrix4d scaled(double x, double y, double z) {
  Matrix4d m;
  m[0][0] = x;
  m[1][1] = y;
  m[2][2] = z;
  return m;
}

// Two unit spheres, the second with an unusable transform. Only the first remains, as if the other did not exist, and
// the report names the second.
TEST(Scene, InstancesThatCannotBeTracedAreLeftOutAndReported) {
  const auto device = make_trace_device({});
  auto prototype = std::make_shared<MeshPrototype>();
  prototype->mesh = testing::sphere_mesh(1, 8, true);
  prototype->object = build_object_scene(device, prototype->mesh, {});
  const auto material = std::make_shared<DisneyMaterial>();
  Matrix4d far, projective;
  far[3][1] = 1e18;
  projective[0][3] = 1;
  for (const Matrix4d& spoilt :
       {scaled(1e-30, 1, 1), scaled(1e-15, 1e-15, 1e-15), scaled(1e-300, 1, 1), scaled(0, 1, 1), scaled(1e18, 1, 1),
        scaled(1e300, 1, 1), scaled(std::numeric_limits<double>::quiet_NaN(), 1, 1), far, projective}) {
    SceneDescription description;
    description.instances = {{prototype, Matrix4d(), {}, {material}, 7, 0, "/good"},
                             {prototype, spoilt, {}, {material}, 8, 0, "/spoilt"}};
    test::RecordingSink sink;
    const auto snapshot = compile_snapshot(description, 1, device, sink.sink());
    ASSERT_TRUE(snapshot);
    ASSERT_EQ(snapshot->instances.size(), 1u) << spoilt;
    EXPECT_EQ(snapshot->instances[0].prim_id, 7);
    ASSERT_EQ(sink.all().size(), 1u) << spoilt;
    EXPECT_EQ(sink.all()[0].code, "instance.transform");
    EXPECT_EQ(sink.all()[0].where, "/spoilt");
    TriangleHit hit;
    const Vec3d eye = Vec3d(0, 0, 5) - snapshot->origin;
    EXPECT_TRUE(snapshot->top->intersect({Vec3f(eye), {0, 0, -1}}, &hit)) << spoilt;
  }
}

// A scene has no natural unit: an object is left out only if it is tiny beside the rest.
TEST(Scene, WholeScenesMayBeTinyOrHuge) {
  const auto device = make_trace_device({});
  auto prototype = std::make_shared<MeshPrototype>();
  prototype->mesh = testing::sphere_mesh(1, 8, true);
  prototype->object = build_object_scene(device, prototype->mesh, {});
  for (const double s : {1e-12, 1e-6, 1.0, 1e6, 1e12}) {
    SceneDescription description;
    description.instances = {{prototype, scaled(s, s, s), {}, {std::make_shared<DisneyMaterial>()}, 0, 0, "/sphere"}};
    test::RecordingSink sink;
    const auto snapshot = compile_snapshot(description, 1, device, sink.sink());
    EXPECT_TRUE(sink.all().empty()) << s;
    ASSERT_EQ(snapshot->instances.size(), 1u) << s;
    TriangleHit hit;
    EXPECT_TRUE(snapshot->top->intersect({Vec3f(0, 0, float(900 * s)), {0, 0, -1}}, &hit)) << s;
  }
}

// A mesh of which one point went astray, beside a sound one: both are drawn where they are, and the origin stays among
// them. An instance beyond single precision even so is named.
TEST(Scene, AStrayPointTakesNoPrecisionFromOthers) {
  const auto device = make_trace_device({});
  const auto prototype_of = [&](Mesh mesh) {
    auto prototype = std::make_shared<MeshPrototype>();
    prototype->mesh = std::move(mesh);
    prototype->object = build_object_scene(device, prototype->mesh, {});
    return prototype;
  };
  const auto sphere = prototype_of(testing::sphere_mesh(1, 8, true));
  for (const Vec3f& point : {Vec3f(1e10f, 0, 0), Vec3f(0, -1e10f, 0), Vec3f(1e12f, 1e12f, 1e12f)}) {
    Mesh stray = testing::sphere_mesh(1, 8, true);
    stray.points.back() = point;
    stray.bounds.extend(point);
    const std::vector<std::shared_ptr<const DisneyMaterial>> materials = {std::make_shared<DisneyMaterial>()};
    SceneDescription description;
    description.instances = {
        {prototype_of(stray), Matrix4d().setTranslation(Vec3d(4, 0, 0)), {}, materials, 0, 0, "/stray"},
        {sphere, Matrix4d(), {}, materials, 0, 0, "/sound"}};
    test::RecordingSink sink;
    const auto snapshot = compile_snapshot(description, 1, device, sink.sink());
    EXPECT_TRUE(sink.all().empty());
    EXPECT_LT(length(snapshot->origin), 10) << point;
    for (const double x : {-0.5, 0.5, 4.5}) {
      TriangleHit hit;
      const Vec3d eye = Vec3d(x, 0.1, 5) - snapshot->origin;
      EXPECT_TRUE(snapshot->top->intersect({Vec3f(eye), {0, 0, -1}}, &hit)) << point << " " << x;
      EXPECT_EQ(hit.instance, x > 2 ? 0u : 1u);
    }

    description.instances.push_back(
        {sphere, Matrix4d().setTranslation(Vec3d(point) * 0.5), {}, materials, 0, 0, "/far"});
    const auto two = compile_snapshot(description, 1, device, sink.sink());
    EXPECT_LT(length(two->origin), 10) << point;
    ASSERT_EQ(sink.all().size(), 1u);
    EXPECT_EQ(sink.all()[0].code, "scene.far");
    EXPECT_EQ(sink.all()[0].where, "/far");
  }
}

class SceneMemory : public ::testing::Test {
 protected:
  static constexpr size_t kTexels = 64 * 32, kTextureBytes = kTexels * sizeof(Rgb);
  const std::shared_ptr<const Texture> image_ =
      std::make_shared<testing::MemoryTexture>(64, std::vector<Rgb>(kTexels, Rgb(0.5f)));

  // Two planes under a sky, each of a material of its own.
  static size_t bytes(const DisneyMaterial& a, const DisneyMaterial& b, const LightParameters& sky) {
    testing::SceneBuilder builder;
    const auto plane = builder.prototype(testing::plane_mesh(1));
    builder.add(plane, std::make_shared<DisneyMaterial>(a)).add(plane, std::make_shared<DisneyMaterial>(b)).add(sky);
    return builder.snapshot()->memory_bytes;
  }
};

TEST_F(SceneMemory, CountsATextureOnceWhoeverHoldsIt) {
  LightParameters sky = testing::constant_dome(1, false);
  const size_t plain = bytes({}, {}, sky);
  DisneyMaterial textured;
  testing::connect("baseColor", image_, &textured);
  EXPECT_EQ(bytes(textured, {}, sky), plain + kTextureBytes);
  EXPECT_EQ(bytes(textured, textured, sky), plain + kTextureBytes);
  sky.texture = image_;
  const size_t tables = bytes({}, {}, sky) - plain - kTextureBytes;
  EXPECT_GE(tables, kTexels * sizeof(float)) << "a dome's image and its distribution";
  EXPECT_LT(tables, 2 * kTexels * sizeof(float));
  EXPECT_EQ(bytes(textured, textured, sky), plain + kTextureBytes + tables) << "image shared with the dome";
}

TEST_F(SceneMemory, CountsMeshLights) {
  const auto bytes_of_sphere = [](float emission) {
    testing::SceneBuilder builder;
    DisneyParameters lamp;
    lamp.emission = Rgb(emission);
    builder.add(builder.prototype(testing::sphere_mesh(1, 16, false)), builder.material(lamp));
    const auto snapshot = builder.snapshot();
    return std::pair(snapshot->memory_bytes, snapshot->instances[0].prototype->mesh.triangles.size());
  };
  const auto [dark, triangles] = bytes_of_sphere(0);
  EXPECT_GE(bytes_of_sphere(1).first, dark + triangles * sizeof(MeshLight::Triangle));
}

}  // namespace
}  // namespace alabaster
