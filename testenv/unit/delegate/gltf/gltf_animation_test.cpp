// Animations, skins and morph targets, against values worked out by hand.
#include <cmath>
#include <functional>

#include "testenv/unit/delegate/gltf/gltf_builder.h"

namespace alabaster::hd::gltf::testing {
namespace {

const float kHalf = std::sqrt(0.5f);  // of a quarter turn's quaternion

// The first point of a triangle whose node is animated.
Vec3d first_point(const GltfBuilder& b, double seconds) {
  const Loaded loaded = b.load_at(seconds);
  EXPECT_TRUE(loaded.summary.ok) << loaded.said();
  return world_points(only_mesh(loaded))[0];
}

TEST(GltfAnimation, StepLinearAndSplineAtTheirKeysAndBetween) {
  const auto x_at = [](const char* interpolation, const std::vector<float>& values, double seconds) {
    GltfBuilder b;
    b.triangle();
    b.animate(0, "translation", {1, 3}, values, "VEC3", interpolation);
    return first_point(b, seconds).x;
  };
  const std::vector<float> keys = {2, 0, 0, 10, 0, 0};
  for (const char* interpolation : {"STEP", "LINEAR"}) {
    EXPECT_EQ(x_at(interpolation, keys, 0), 2) << "before the first key the first";
    EXPECT_EQ(x_at(interpolation, keys, 1), 2);
    EXPECT_EQ(x_at(interpolation, keys, 3), 10);
    EXPECT_EQ(x_at(interpolation, keys, 9), 10) << "after the last key the last";
  }
  EXPECT_EQ(x_at("STEP", keys, 2.999), 2);
  EXPECT_NEAR(x_at("LINEAR", keys, 1.5), 4, 1e-6);
  // Hermite's polynomials at u = 1/4 over two seconds, with out-tangent 3 and in-tangent -5 per second.
  const std::vector<float> spline = {7, 0, 0, 2, 0, 0, 3, 0, 0, -5, 0, 0, 10, 0, 0, 8, 0, 0};
  const double u = 0.25, expected = (1 + 2 * u) * (1 - u) * (1 - u) * 2 + 2 * u * (1 - u) * (1 - u) * 3 +
                                    u * u * (3 - 2 * u) * 10 + 2 * u * u * (u - 1) * -5;
  EXPECT_NEAR(x_at("CUBICSPLINE", spline, 1.5), expected, 1e-6);
  EXPECT_EQ(x_at("CUBICSPLINE", spline, 1), 2);
  EXPECT_EQ(x_at("CUBICSPLINE", spline, 3), 10);
}

// From no turn to a quarter turn around z, given as the far quaternion of the same rotation: the shorter arc counts.
TEST(GltfAnimation, RotationsGoAlongTheShorterArcAtEvenSpeed) {
  GltfBuilder b;
  b.attribute<float>("POSITION", {1, 0, 0, 0, 1, 0, 0, 0, 1}, "VEC3");
  b.animate(0, "rotation", {0, 3}, {0, 0, 0, 1, 0, 0, -kHalf, -kHalf}, "VEC4");
  for (const double third : {0.0, 1.0, 2.0, 3.0}) {
    const double angle = third * std::acos(-1.0) / 6;
    expect_near(first_point(b, third), Vec3d(std::cos(angle), std::sin(angle), 0));
  }
}

TEST(GltfAnimation, NormalizedIntegersAreRotations) {
  GltfBuilder b;
  b.attribute<float>("POSITION", {1, 0, 0, 0, 1, 0, 0, 0, 1}, "VEC3");
  b.animate(0, "rotation", {0}, {0, 0, 0, 1}, "VEC4");
  b.json["animations"][0]["samplers"][0]["output"] = b.add<int16_t>({0, 0, 32767, 0}, "VEC4", true);
  expect_near(first_point(b, 0), Vec3d(-1, 0, 0));
}

TEST(GltfAnimation, WithoutATimeNodesKeepTheirOwnPose) {
  GltfBuilder b;
  b.triangle();
  b.node()["translation"] = {5, 0, 0};
  b.animate(0, "translation", {0, 2}, {1, 0, 0, 3, 0, 0}, "VEC3");
  b.json["animations"][0]["name"] = "walk";
  b.json["animations"].push_back(b.json["animations"][0]);
  b.json["animations"][1]["name"] = "run";
  b.json["animations"][1]["samplers"][0]["output"] = b.add<float>({7, 0, 0, 9, 0, 0}, "VEC3");
  const Loaded rest = b.load();
  EXPECT_EQ(world_points(only_mesh(rest))[0].x, 5);
  ASSERT_EQ(rest.summary.animations.size(), 2u);
  EXPECT_EQ(rest.summary.animations[1].name, "run");
  EXPECT_EQ(rest.summary.animations[1].seconds, 2);
  EXPECT_EQ(first_point(b, 0).x, 1);  // the first animation
  GltfOptions options;
  options.animation = "run";
  EXPECT_EQ(world_points(only_mesh(b.load(options)))[0].x, 7) << "a named animation begins at 0";
  options.time = 1;
  EXPECT_EQ(world_points(only_mesh(b.load(options)))[0].x, 8);
  options.animation = "fly";
  EXPECT_TRUE(b.load(options).says(Severity::error, "has no animation 'fly'; choose from 0 'walk', 1 'run'"));
}

TEST(GltfAnimation, ANameIsFoundBeforeANumber) {
  GltfBuilder b;
  b.triangle();
  b.animate(0, "translation", {0, 2}, {1, 0, 0, 3, 0, 0}, "VEC3");
  b.json["animations"].push_back(b.json["animations"][0]);
  b.json["animations"][0]["name"] = "1";
  b.json["animations"][1]["samplers"][0]["output"] = b.add<float>({7, 0, 0, 9, 0, 0}, "VEC3");
  const auto first_x = [&](const char* animation) {
    GltfOptions options;
    options.animation = animation;
    return world_points(only_mesh(b.load(options)))[0].x;
  };
  EXPECT_EQ(first_x("1"), 1);
  EXPECT_EQ(first_x("0"), 1) << "a number that is no name";
  b.json["animations"][1]["name"] = "0";
  EXPECT_EQ(first_x("0"), 7);
}

TEST(GltfAnimation, FaultsAreErrorsWhereTheAnimationIsUsed) {
  const auto expect_fault = [](const std::string& what, const std::function<void(GltfBuilder&)>& damage) {
    GltfBuilder b;
    b.triangle();
    b.animate(0, "translation", {0, 2}, {1, 0, 0, 3, 0, 0}, "VEC3");
    damage(b);
    const Loaded used = b.load_at(1), unused = b.load();
    EXPECT_FALSE(used.summary.ok) << what;
    EXPECT_TRUE(used.says(Severity::error, what)) << what << "\n" << used.said();
    EXPECT_TRUE(used.says(Severity::error, "made.glb: animations[0]")) << used.said();
    EXPECT_TRUE(unused.summary.ok && unused.says(Severity::warning, what)) << what << "\n" << unused.said();
  };
  const auto sampler = [](GltfBuilder& b) -> Json& { return b.json["animations"][0]["samplers"][0]; };
  expect_fault("time 1 is not", [&](GltfBuilder& b) { sampler(b)["input"] = b.add<float>({2, 2}, "SCALAR"); });
  expect_fault("time 1 is not", [&](GltfBuilder& b) { sampler(b)["input"] = b.add<float>({0, NAN}, "SCALAR"); });
  expect_fault("time 0 is not", [&](GltfBuilder& b) { sampler(b)["input"] = b.add<float>({-1, 1}, "SCALAR"); });
  expect_fault("scalars of floats", [&](GltfBuilder& b) { sampler(b)["input"] = b.add<uint16_t>({0, 1}, "SCALAR"); });
  expect_fault("3 times and 2 values, not 3", [&](GltfBuilder& b) {
    sampler(b)["input"] = b.add<float>({0, 1, 2}, "SCALAR");
  });
  expect_fault("2 times and 2 values, not 6", [&](GltfBuilder& b) { sampler(b)["interpolation"] = "CUBICSPLINE"; });
  expect_fault("must be VEC3 of floats", [&](GltfBuilder& b) {
    sampler(b)["output"] = b.add<float>({0, 0, 0, 1, 0, 0, 0, 1}, "VEC4");
  });
  expect_fault("value 1 is not a finite", [&](GltfBuilder& b) {
    sampler(b)["output"] = b.add<float>({0, 0, 0, 0, INFINITY, 0}, "VEC3");
  });
  expect_fault("7 is out of range", [](GltfBuilder& b) { b.json["animations"][0]["channels"][0]["sampler"] = 7; });
}

TEST(GltfAnimation, ChannelsThatCannotMoveAnythingAreLeftOut) {
  const auto expect_left_out = [](const std::string& what, const std::function<void(GltfBuilder&, Json&)>& change) {
    GltfBuilder b;
    b.triangle();
    b.animate(0, "translation", {0}, {1, 0, 0}, "VEC3");
    change(b, b.json["animations"][0]["channels"][0]["target"]);
    const Loaded loaded = b.load_at(0);
    EXPECT_TRUE(loaded.summary.ok && loaded.says(Severity::warning, what)) << loaded.said();
    EXPECT_EQ(world_points(only_mesh(loaded))[0].x, 0);
  };
  expect_left_out("has no node", [](GltfBuilder&, Json& target) { target.erase("node"); });
  expect_left_out("KHR_animation_pointer is not supported", [](GltfBuilder&, Json& target) {
    target = {{"path", "pointer"}, {"extensions", {{"KHR_animation_pointer", {{"pointer", "/nodes/0/scale"}}}}}};
  });
  expect_left_out("has no morph targets", [](GltfBuilder&, Json& target) { target["path"] = "weights"; });
  expect_left_out("has a matrix",
                  [](GltfBuilder& b, Json&) { b.node()["matrix"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}; });
}

// Node 0 has the mesh and a translation that must not count; 1 and 2 are joints, 2 below 1.
GltfBuilder skinned() {
  GltfBuilder b;
  b.attribute<float>("POSITION", {0, 0, 0, 0, 2, 0, 1, 2, 0}, "VEC3");
  b.attribute<float>("NORMAL", {1, 0, 0, 1, 0, 0, 0, 0, 1}, "VEC3");
  b.attribute<float>("TANGENT", {0, 1, 0, 1, 0, 1, 0, 1, 1, 0, 0, -1}, "VEC4");
  b.attribute<uint8_t>("JOINTS_0", {0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 9, 0}, "VEC4");
  b.attribute<float>("WEIGHTS_0", {1, 0, 0, 0, 1, 0, 0, 0, 0.5f, 0.5f, 0, 0}, "VEC4");
  b.node() = {{"mesh", 0}, {"skin", 0}, {"translation", {100, 0, 0}}};
  b.json["nodes"].push_back({{"children", {2}}, {"translation", {0, 0, 5}}});
  b.json["nodes"].push_back({{"translation", {0, 1, 0}}});
  b.json["scenes"][0]["nodes"] = {0, 1};
  b.json["skins"] = {{{"joints", {1, 2}}}};
  b.json["skins"][0]["inverseBindMatrices"] = b.add<float>({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0,  0, 1,  //
                                                            1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -1, 0, 1},
                                                           "MAT4");
  return b;
}

TEST(GltfSkin, VerticesFollowTheirJointsAndNotTheirNode) {
  GltfBuilder b = skinned();
  const Loaded rest = b.load();
  std::vector<Vec3d> points = world_points(only_mesh(rest));
  expect_near(points[1], Vec3d(0, 2, 5));
  expect_near(points[2], Vec3d(1, 2, 5));

  b.node(2)["rotation"] = {0, 0, kHalf, kHalf};  // a quarter turn of the second joint, at (0,1,5): y becomes -x
  const Loaded turned = b.load();
  const host::MeshDescription& mesh = only_mesh(turned);
  points = world_points(mesh);
  expect_near(points[0], Vec3d(0, 0, 5));
  expect_near(points[1], Vec3d(-1, 1, 5));
  expect_near(points[2], (Vec3d(1, 2, 5) + Vec3d(-1, 2, 5)) * 0.5);  // half each
  expect_near(primvar<Array<Vec3f>>(mesh, "normals")[1], Vec3f(0, 1, 0));
  expect_near(primvar<Array<Vec4f>>(mesh, "tangents")[1], Vec4f(-1, 0, 0, 1));
  EXPECT_EQ(mesh.topology.orientation, Token("rightHanded"));
}

TEST(GltfSkin, AnimatedJointsMoveIt) {
  GltfBuilder b = skinned();
  b.animate(2, "rotation", {0, 1}, {0, 0, 0, 1, 0, 0, kHalf, kHalf}, "VEC4");
  const double s = std::sqrt(0.5);
  expect_near(world_points(only_mesh(b.load_at(0.5)))[1], Vec3d(-s, 1 + s, 5));
  expect_near(world_points(only_mesh(b.load_at(1)))[1], Vec3d(-1, 1, 5));
}

TEST(GltfSkin, MirroredJointsTurnTheWindingNotTheNormals) {
  GltfBuilder b = skinned();
  b.node(1)["scale"] = {-1, 1, 1};
  const Loaded loaded = b.load();
  const host::MeshDescription& mesh = only_mesh(loaded);
  EXPECT_EQ(mesh.topology.orientation, Token("leftHanded"));
  expect_near(primvar<Array<Vec3f>>(mesh, "normals")[0], Vec3f(-1, 0, 0));
  expect_near(primvar<Array<Vec4f>>(mesh, "tangents")[2], Vec4f(-1, 0, 0, 1));
}

TEST(GltfSkin, FurtherSetsCountAndWeightsNeedNotAddUp) {
  GltfBuilder b = skinned();
  b.node(2)["translation"] = {8, 1, 0};
  b.attribute<uint16_t>("JOINTS_1", {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4");
  b.attribute<uint8_t>("WEIGHTS_0", {51, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, "VEC4", true);
  b.attribute<uint8_t>("WEIGHTS_1", {51, 0, 0, 0, 255, 0, 0, 0, 0, 0, 0, 0}, "VEC4", true);
  const std::vector<Vec3d> points = world_points(only_mesh(b.load()));
  expect_near(points[0], Vec3d(4, 0, 5));  // half of each joint
  expect_near(points[1], Vec3d(8, 2, 5));
  expect_near(points[2], Vec3d(1, 2, 5));  // none: the first joint
}

TEST(GltfSkin, FaultsAreNamed) {
  const auto expect_fault = [](const std::string& what, const std::function<void(GltfBuilder&)>& damage) {
    GltfBuilder b = skinned();
    damage(b);
    const Loaded loaded = b.load();
    EXPECT_FALSE(loaded.summary.ok) << what;
    EXPECT_TRUE(loaded.says(Severity::error, what)) << what << "\n" << loaded.said();
  };
  expect_fault("vertex 1 follows joint 1, but the skin has 1",
               [](GltfBuilder& b) { b.json["skins"][0]["joints"] = {1}; });
  expect_fault("has 1 matrices, but the skin has 2 joints", [](GltfBuilder& b) {
    b.json["skins"][0]["inverseBindMatrices"] = b.add<float>(std::vector<float>(16, 0), "MAT4");
  });
  expect_fault("must be MAT4 of floats", [](GltfBuilder& b) { b.json["skins"][0]["inverseBindMatrices"] = 0; });
  expect_fault("matrix 1 is not of finite", [](GltfBuilder& b) {
    std::vector<float> matrices(32, 0);
    matrices[20] = NAN;
    b.json["skins"][0]["inverseBindMatrices"] = b.add(matrices, "MAT4");
  });
  expect_fault("weights of vertex 2 are not finite", [](GltfBuilder& b) {
    b.attribute<float>("WEIGHTS_0", {1, 0, 0, 0, 1, 0, 0, 0, 0.5f, -1, 0, 0}, "VEC4");
  });
  expect_fault("JOINTS_0 must hold 8-bit or 16-bit unsigned",
               [](GltfBuilder& b) { b.attribute<float>("JOINTS_0", std::vector<float>(12, 0), "VEC4"); });
  expect_fault("skins[0].joints[1]", [](GltfBuilder& b) { b.json["skins"][0]["joints"] = {1, 12}; });
}

GltfBuilder morphed() {
  GltfBuilder b;
  b.triangle();
  b.attribute<float>("NORMAL", {0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3");
  b.attribute<float>("TANGENT", {1, 0, 0, -1, 1, 0, 0, -1, 1, 0, 0, -1}, "VEC4");
  b.primitive()["targets"] = {{{"POSITION", b.add<float>({0, 0, 2, 0, 0, 2, 0, 0, 2}, "VEC3")}},
                              {{"POSITION", b.add_sparse(3, {1}, {4, 0, 0}, "VEC3")},
                               {"NORMAL", b.add_sparse(3, {1}, {0, 1, -1}, "VEC3")},
                               {"TANGENT", b.add_sparse(3, {1}, {0, 2, 0}, "VEC3")}}};
  return b;
}

TEST(GltfMorph, TargetsAreAddedByWeight) {
  GltfBuilder b = morphed();
  EXPECT_EQ(primvar<Array<Vec3f>>(only_mesh(b.load()), "points")[1], Vec3f(1, 0, 0));
  b.json["meshes"][0]["weights"] = {0.25, 1};
  const Loaded by_mesh = b.load();
  const host::MeshDescription& mesh = only_mesh(by_mesh);
  expect_near(primvar<Array<Vec3f>>(mesh, "points")[0], Vec3f(0, 0, 0.5f));
  expect_near(primvar<Array<Vec3f>>(mesh, "points")[1], Vec3f(5, 0, 0.5f));
  expect_near(primvar<Array<Vec3f>>(mesh, "normals")[1], Vec3f(0, 1, 0));
  expect_near(primvar<Array<Vec4f>>(mesh, "tangents")[1], Vec4f(1, 2, 0, -1));
  b.node()["weights"] = {0, 0.5};  // a node's own replace the mesh's
  expect_near(primvar<Array<Vec3f>>(only_mesh(b.load()), "points")[1], Vec3f(3, 0, 0));
}

TEST(GltfMorph, NodesWithOtherWeightsHaveMeshesOfTheirOwn) {
  GltfBuilder b = morphed();
  b.json["nodes"] = {{{"mesh", 0}}, {{"mesh", 0}, {"weights", {1, 0}}}, {{"mesh", 0}, {"weights", {0, 0}}}};
  b.json["scenes"][0]["nodes"] = {0, 1, 2};
  const Loaded loaded = b.load();
  ASSERT_EQ(loaded.scene->GetMeshes().size(), 2u) << loaded.said();  // nodes 0 and 2 share one
  EXPECT_EQ(primvar<Array<Vec3f>>(loaded.scene->GetMeshes().at("/gltf/made/nodes/1/0"), "points")[0], Vec3f(0, 0, 2));
  EXPECT_EQ(loaded.scene->GetInstancers().begin()->second.indices.begin()->second.size(), 2u);
}

TEST(GltfMorph, WeightsAreAnimatedByKeyAndBySpline) {
  GltfBuilder b = morphed();
  b.animate(0, "weights", {0, 1}, {0, 0, 1, 0.5f}, "SCALAR");
  expect_near(primvar<Array<Vec3f>>(only_mesh(b.load_at(0.5)), "points")[1], Vec3f(2, 0, 1));
  GltfBuilder spline = morphed();  // each key: two in-tangents, two values, two out-tangents
  spline.animate(0, "weights", {0, 1}, {0, 0, 0, 0, 0, 4, 0, 0, 1, 0, 0, 0}, "SCALAR", "CUBICSPLINE");
  const double u = 0.5, first = u * u * (3 - 2 * u), second = 4 * u * (1 - u) * (1 - u);
  expect_near(primvar<Array<Vec3f>>(only_mesh(spline.load_at(0.5)), "points")[1],
              Vec3f(float(1 + 4 * second), 0, float(2 * first)));
}

TEST(GltfMorph, TargetsMoveBeforeTheSkin) {
  GltfBuilder b = skinned();
  b.node(2)["rotation"] = {0, 0, kHalf, kHalf};
  b.primitive()["targets"] = {{{"POSITION", b.add_sparse(3, {1}, {0, 1, 0}, "VEC3")}}};
  b.node()["weights"] = {1};
  expect_near(world_points(only_mesh(b.load()))[1], Vec3d(-2, 1, 5));
}

TEST(GltfMorph, FaultsAreNamed) {
  const auto says = [](Severity severity, const std::string& what, const std::function<void(GltfBuilder&)>& damage) {
    GltfBuilder b = morphed();
    b.json["meshes"][0]["weights"] = {1, 1};
    damage(b);
    const Loaded loaded = b.load();
    EXPECT_EQ(loaded.summary.ok, severity != Severity::error) << what;
    EXPECT_TRUE(loaded.says(severity, what)) << what << "\n" << loaded.said();
  };
  const auto target = [](GltfBuilder& b) -> Json& { return b.primitive()["targets"][0]; };
  says(Severity::error, "targets[0].POSITION has 1 elements, but the primitive has 3 vertices", [&](GltfBuilder& b) {
    target(b)["POSITION"] = b.add<float>({0, 0, 0}, "VEC3");
  });
  says(Severity::error, "targets[0].TANGENT is of type VEC4, not one of |VEC3|",
       [&](GltfBuilder& b) { target(b)["TANGENT"] = b.primitive()["attributes"]["TANGENT"]; });
  says(Severity::error, "targets[0].POSITION element 2 is not a finite", [&](GltfBuilder& b) {
    target(b)["POSITION"] = b.add<float>({0, 0, 0, 0, 0, 0, 0, NAN, 0}, "VEC3");
  });
  says(Severity::error, "targets[0].POSITION", [&](GltfBuilder& b) { target(b)["POSITION"] = 99; });
  says(Severity::warning, "moves an attribute that the primitive lacks",
       [&](GltfBuilder& b) { target(b)["COLOR_0"] = b.add<float>(std::vector<float>(9, 0), "VEC3"); });
  says(Severity::warning, "3 are given, but there are 2 morph targets", [](GltfBuilder& b) {
    b.json["meshes"][0]["weights"] = {1, 1, 1};
  });
  says(Severity::warning, "1 are given, but the mesh has 2 morph targets",
       [](GltfBuilder& b) { b.node()["weights"] = {1}; });
}

}  // namespace
}  // namespace alabaster::hd::gltf::testing
