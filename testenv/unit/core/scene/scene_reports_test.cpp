#include "core/scene/scene_reports.h"

#include <gtest/gtest.h>

#include "testenv/support/medium_bodies.h"
#include "testenv/support/scene_builder.h"

namespace alabaster {
namespace {

using testing::SceneBuilder;

DisneyParameters wax() {
  DisneyParameters p;
  p.scatter_distance = Rgb(0.2f);
  return p;
}

LightParameters lamp(double x, const char* name) {
  LightParameters light;
  light.type = LightType::sphere;
  light.radius = 0.05f;
  light.light_to_world = testing::moved(x);
  light.name = name;
  return light;
}

/// Warnings of a scene of one code.
std::vector<Diagnostic> warnings(const SceneBuilder& b, const std::string& code) {
  std::vector<Diagnostic> found;
  const DiagnosticSink sink = [&](const Diagnostic& d) {
    if (d.code == code) found.push_back(d);
  };
  EXPECT_TRUE(compile_snapshot(b.description, 1, make_trace_device(sink), sink));
  return found;
}

TEST(SceneReports, ALightWithinABodyIsNamedWithIt) {
  SceneBuilder b;
  b.add(b.prototype(testing::sphere_mesh(1, 16, true)), b.material(wax()), testing::moved(4));
  b.description.instances.back().name = "/candle";
  b.add(lamp(0, "/outside")).add(lamp(4.5, "/inside")).add(testing::constant_dome(1, true));
  auto found = warnings(b, "light.within");
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].where, "/inside");
  EXPECT_NE(found[0].text.find("/candle"), std::string::npos) << found[0].text;
  b.add(lamp(4, "/second")).add(lamp(3.5, "/third"));
  found = warnings(b, "light.within");
  ASSERT_EQ(found.size(), 1u) << "one for each body";
  EXPECT_NE(found[0].text.find("2 others"), std::string::npos) << found[0].text;
}

TEST(SceneReports, AnEmissiveMeshWithinABodyIsNamedToo) {
  SceneBuilder b;
  DisneyParameters glow;
  glow.emission = Rgb(1.0f);
  b.add(b.prototype(testing::sphere_mesh(1, 16, true)), b.material(wax()), testing::moved(4));
  b.add(b.prototype(testing::sphere_mesh(0.3f, 8, true)), b.material(glow), testing::moved(4.2));
  b.description.instances[0].name = "/lantern", b.description.instances[1].name = "/bulb";
  const auto found = warnings(b, "light.within");
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].where, "/bulb");
  EXPECT_NE(found[0].text.find("/lantern"), std::string::npos);
  b.description.instances[1].object_to_world = testing::moved(5);  // half of it sticks out
  EXPECT_TRUE(warnings(b, "light.within").empty());
}

TEST(SceneReports, ASetOfTwoMediaBehindClearWallsIsTold) {
  SceneBuilder b;
  DisneyParameters milk = wax(), jelly = wax();
  milk.spec_trans = jelly.spec_trans = 1, jelly.base_color = Rgb(0.5f, 0.2f, 0.1f);
  const auto ball = b.prototype(testing::sphere_mesh(1, 16, true));
  b.add(ball, b.material(milk)).add(ball, b.material(milk), testing::moved(1));
  b.add(ball, b.material(jelly), testing::moved(2));
  for (auto& instance : b.description.instances) instance.subsurface_set = "drink";
  b.description.instances[0].name = "/milk", b.description.instances[2].subsurface_set = "";
  EXPECT_TRUE(warnings(b, "subsurface.set").empty());
  b.description.instances[2].subsurface_set = "drink";
  const auto found = warnings(b, "subsurface.set");
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].where, "/milk");
}

TEST(SceneReports, AClearBoneIsTold) {
  SceneBuilder b;
  DisneyParameters bone, glass;
  glass.spec_trans = 1;
  const auto ball = b.prototype(testing::sphere_mesh(1, 16, true));
  b.add(ball, b.material(wax())).add(ball, b.material(bone)).add(ball, b.material(glass));
  for (auto& instance : b.description.instances) instance.subsurface_set = "hand";
  b.description.instances[2].name = "/glass", b.description.instances[2].subsurface_set = "";
  EXPECT_TRUE(warnings(b, "subsurface.set").empty());
  b.description.instances[2].subsurface_set = "hand";
  const auto found = warnings(b, "subsurface.set");
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].where, "/glass");
}

TEST(SceneReports, ALightBehindAClearWallIsNoisyAndOneWithoutSizeGivesNone) {
  DisneyParameters milk = wax();
  milk.spec_trans = 1;
  struct Case {
    float radius;
    bool treat_as_point;
    const char* told;
  };
  for (const auto& [radius, as_point, told] : {Case{0.05f, false, "noisy"},
                                               {-0.05f, false, "noisy"},
                                               {0, false, "without size"},
                                               {0.05f, true, "without size"}}) {
    SceneBuilder b;
    b.add(b.prototype(testing::sphere_mesh(1, 16, true)), b.material(milk));
    LightParameters light = lamp(0.5, "/inside");
    light.radius = radius;
    light.treat_as_point = as_point;
    b.add(light);
    const auto found = warnings(b, "light.within");
    ASSERT_EQ(found.size(), 1u);
    EXPECT_NE(found[0].text.find(told), std::string::npos) << found[0].text;
  }
}

TEST(SceneReports, AnOpenClearMeshIsToldToStayClear) {
  DisneyParameters milk = wax();
  milk.spec_trans = 1;
  SceneBuilder b;
  b.add(b.prototype(testing::plane_mesh(2)), b.material(milk));
  const auto found = warnings(b, "mesh.open");
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NE(found[0].text.find("it is clear"), std::string::npos) << found[0].text;
}

TEST(SceneReports, ALightInACavityOrAClearBodyOrAnUnscatteringOneIsNotReported) {
  SceneBuilder b;
  Mesh shell = testing::sphere_mesh(1, 16, true);
  const Mesh hole = testing::sphere_mesh(0.4f, 16, true);
  const auto first = static_cast<uint32_t>(shell.points.size());
  shell.points.insert(shell.points.end(), hole.points.begin(), hole.points.end());
  shell.normals.clear(), shell.normal_triangles.clear();
  for (const Corners& c : hole.triangles) shell.triangles.push_back({c[0] + first, c[2] + first, c[1] + first});
  b.add(b.prototype(shell), b.material(wax())).add(lamp(0, "/in_cavity"));
  b.add(b.prototype(testing::sphere_mesh(1, 16, true)), b.material({}), testing::moved(5)).add(lamp(5, "/in_opaque"));
  EXPECT_TRUE(warnings(b, "light.within").empty());
  b.add(lamp(0.7, "/in_wall"));
  EXPECT_EQ(warnings(b, "light.within").size(), 1u);
}

Mesh slab(float thickness, float at) {
  Cage cage;
  for (int i = 0; i < 8; ++i)
    cage.points.emplace_back(i & 1 ? 1.0f : -1.0f, at + (i & 2 ? thickness : 0.0f), i & 4 ? 1.0f : -1.0f);
  cage.face_vertex_counts.assign(6, 4);
  cage.face_vertex_indices = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5};
  return build_mesh(cage, {}, {});
}

TEST(SceneReports, LightsWithoutSizeBesideClearSolidsAreReported) {
  DisneyParameters glass;
  glass.spec_trans = 1;
  const auto found = [&](const DisneyParameters& p, const LightParameters* more = nullptr) {
    SceneBuilder b;
    b.add(b.prototype(testing::sphere_mesh(1, 16, true)), b.material(p));
    b.description.instances.back().name = "/vase";
    LightParameters bulb = lamp(3, "/bulb"), sun;
    bulb.treat_as_point = true;
    sun.type = LightType::distant, sun.angle = 0, sun.name = "/sun";
    b.add(bulb).add(sun);
    if (more) b.add(*more);
    return warnings(b, "light.withoutSize");
  };
  ASSERT_EQ(found(glass).size(), 1u);
  EXPECT_EQ(found(glass)[0].where, "/bulb");
  EXPECT_NE(found(glass)[0].text.find("/vase"), std::string::npos);

  // Another light, or nothing that refracts.
  const LightParameters sized = lamp(4, "/lamp"), sky = testing::constant_dome(1, true);
  EXPECT_TRUE(found(glass, &sized).empty());
  EXPECT_TRUE(found(glass, &sky).empty());
  EXPECT_TRUE(found(wax()).empty());
  DisneyParameters pane = glass, index_of_air = glass;
  pane.thin = true, index_of_air.ior = 1;
  EXPECT_TRUE(found(pane).empty());
  EXPECT_TRUE(found(index_of_air).empty());
}

TEST(SceneReports, ASlabThinnerThanRoundingIsReported) {
  for (const auto& [thickness, count] : {std::pair(1e-3f, 0u), std::pair(1e-5f, 0u), std::pair(2e-7f, 1u)}) {
    SceneBuilder b;
    b.add(b.prototype(slab(thickness, 0.5f)), b.material(wax()));
    b.description.instances.back().name = "/sheet";
    const auto found = warnings(b, "subsurface.thin");
    ASSERT_EQ(found.size(), count) << thickness;
    for (const Diagnostic& d : found) EXPECT_EQ(d.where, "/sheet");
  }
}

TEST(SceneReports, PointsFarFromTheMeshsOriginThatLoseAChannelAreReported) {
  for (const auto& [at, count] : {std::pair(0.5f, 0u), std::pair(1e3f, 0u), std::pair(3e4f, 1u)}) {
    SceneBuilder b;
    b.add(b.prototype(slab(2, at)), b.material(wax()));
    b.description.instances.back().name = "/scan";
    const auto found = warnings(b, "subsurface.farFromOrigin");
    ASSERT_EQ(found.size(), count) << at;
    for (const Diagnostic& d : found) EXPECT_EQ(d.where, "/scan");
  }
}

TEST(SceneReports, ADistanceThatExceedsTheBodyIsReportedOnceForAMaterial) {
  for (const auto& [radius, count] : {std::pair(1.0f, 0u), std::pair(0.05f, 1u)}) {
    SceneBuilder b;
    const auto skin = b.material(wax());
    for (const char* name : {"/head", "/hand"}) {
      b.add(b.prototype(testing::sphere_mesh(radius, 16, true)), skin, testing::moved(3));
      b.description.instances.back().name = name;
    }
    const auto found = warnings(b, "subsurface.farDistance");
    ASSERT_EQ(found.size(), count) << radius;
    for (const Diagnostic& d : found) {
      EXPECT_EQ(d.where, "/head");
      EXPECT_NE(d.text.find("0.2 millimetres are 0.0002"), std::string::npos) << d.text;
    }
  }
}

}  // namespace
}  // namespace alabaster
