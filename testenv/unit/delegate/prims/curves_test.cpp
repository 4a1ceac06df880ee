// Curves and points, which are drawn as closed meshes.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "core/geometry/mesh.h"
#include "core/geometry/reversed_edges.h"
#include "delegate/prims/points.h"
#include "delegate/prims/tubes.h"
#include "testenv/support/drawing.h"
#include "testenv/support/stage.h"

namespace alabaster::hd {
namespace {

constexpr double kPi = std::numbers::pi;

host::MeshDescription curves(const char* type, const char* basis, const char* wrap, std::vector<Vec3f> points,
                             std::vector<int32_t> counts = {}) {
  host::MeshDescription prim;
  prim.type = "basisCurves";
  if (counts.empty()) counts = {static_cast<int32_t>(points.size())};
  prim.curves = {type, basis, wrap, Array<int32_t>(std::move(counts))};
  prim.primvars["points"].value = Array<Vec3f>(std::move(points));
  return prim;
}
host::MeshDescription with_widths(host::MeshDescription prim, std::vector<float> widths,
                                  Interpolation interpolation = Interpolation::constant) {
  prim.primvars["widths"] = {interpolation, {}, Array<float>(std::move(widths)), {}};
  return prim;
}

prims::PulledPrimvar pulled(const host::MeshDescription& prim, const char* name) {
  const auto found = prim.primvars.find(name);
  if (found == prim.primvars.end()) return {};
  return {true, found->second.interpolation, found->second.value, found->second.indices};
}

/// As the renderer builds it.
Mesh build(const prims::PulledMesh& shape) {
  Cage cage = prims::make_cage(shape, {}, "/test", {});
  EXPECT_TRUE(sanitize_cage(cage, "/test", {}));
  return build_mesh(cage, {}, {});
}
Mesh tube(const host::MeshDescription& prim) {
  prims::PulledMesh shape;
  shape.curves = prim.curves;
  shape.points = pulled(prim, "points"), shape.widths = pulled(prim, "widths");
  return build(prims::make_tubes(shape, {}, "/test", {}, std::make_shared<MemoryBudget>(), {}).mesh);
}

struct Measures {
  double volume = 0, area = 0;
};
Measures measure(const Mesh& mesh) {
  Measures m;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3d p(mesh.points[a]), q(mesh.points[b]), r(mesh.points[c]);
    m.volume += p.dot(q.cross(r)) / 6;
    m.area += (q - p).cross(r - p).length() / 2;
  }
  return m;
}

void expect_solid(const Mesh& mesh, const std::string& which) {
  EXPECT_TRUE(mesh.closed && mesh.sealed && mesh.outward) << which;
  EXPECT_EQ(find_reversed_edges(mesh).count, 0u) << which;
  for (const Vec3f& n : mesh.normals) ASSERT_NEAR(n.length(), 1, 1e-4) << which;
}

// promise: usd.curves.tubes
TEST(Curves, ATubeHasTheVolumeOfTheRoundOneAcrossItsCornersToo) {
  const double radius = 0.2, cap = kPi * radius * radius;
  const Mesh straight = tube(with_widths(curves("linear", "bezier", "nonperiodic", {{1, 2, 3}, {2, 4, 5}}), {0.4f}));
  expect_solid(straight, "straight");
  EXPECT_NEAR(measure(straight).volume, 3 * cap, 1e-5 * cap);
  EXPECT_NEAR(measure(straight).area, 2 * cap + 3 * 2 * kPi * radius, 0.012 * 3 * 2 * kPi * radius);
  EXPECT_EQ(straight.triangles.size(), 12u * 2 + 2 * 10);
  const Mesh bent = tube(
      with_widths(curves("linear", "bezier", "nonperiodic", {{0, 0, 0}, {3, 0, 0}, {3, 4, 0}, {3, 4, 2}}), {0.4f}));
  expect_solid(bent, "bent");
  EXPECT_NEAR(measure(bent).volume, 9 * cap, 1e-4 * cap);
  const Mesh square =
      tube(with_widths(curves("linear", "bezier", "periodic", {{0, 0, 0}, {2, 0, 0}, {2, 2, 1}, {0, 2, 0}}), {0.4f}));
  expect_solid(square, "square");
  EXPECT_NEAR(measure(square).volume, (2 + std::sqrt(5.0) * 2 + 2) * cap, 0.01 * cap);
  const Mesh cone = tube(
      with_widths(curves("linear", "bezier", "nonperiodic", {{0, 0, 0}, {0, 0, 3}}), {0.4f, 0}, Interpolation::vertex));
  expect_solid(cone, "cone");
  EXPECT_NEAR(measure(cone).volume, cap, 1e-5 * cap);
}

TEST(Curves, ManyHaveSixSides) {
  constexpr int kCurves = 100001;
  std::vector<Vec3f> points;
  for (int i = 0; i < 2 * kCurves; ++i) points.emplace_back(float(i / 2 % 300), float(i % 2), float(i / 600));
  const Mesh many =
      tube(with_widths(curves("linear", "bezier", "nonperiodic", points, std::vector<int32_t>(kCurves, 2)), {0.4f}));
  EXPECT_EQ(many.triangles.size(), size_t(kCurves) * (6 * 2 + 2 * 4));
  EXPECT_NEAR(measure(many).volume / kCurves, kPi * 0.04, 1e-4);
}

// All curves that there are, with widths that taper to nothing at an end or within.
TEST(Curves, EveryBasisAndWrapIsAClosedBodyThatFacesOutward) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> place(-1, 1), width(0.001f, 0.02f);
  for (const char* type : {"linear", "cubic"})
    for (const char* basis : {"bezier", "bspline", "catmullRom"})
      for (const char* wrap : {"nonperiodic", "periodic", "pinned"})
        for (int run = 0; run < 4; ++run) {
          const bool is_bezier = std::string(basis) == "bezier", is_closed = std::string(wrap) == "periodic";
          const size_t count = is_bezier ? is_closed ? 6 : 7 : 5;
          std::vector<Vec3f> points;
          std::vector<float> widths;
          for (size_t i = 0; i < count; ++i) {
            points.emplace_back(place(random), place(random), place(random));
            widths.push_back(width(random));
          }
          if (run == 1) widths.front() = 0;
          if (run == 2) widths.back() = 0;
          if (run == 3) widths[2] = 0, points[1] = points[0];
          expect_solid(tube(with_widths(curves(type, basis, wrap, points), widths, Interpolation::vertex)),
                       std::string(type) + " " + basis + " " + wrap + " " + std::to_string(run));
        }
}

// The same cubic, by its control points in each basis; pinned curves reach their end points.
TEST(Curves, OneCurveIsTheSameInEachBasis) {
  const Vec3f p[4] = {{0, 0, 0}, {1, 3, 0}, {2, -1, 1}, {4, 1, 2}};
  const Mesh spline = tube(with_widths(curves("cubic", "bspline", "nonperiodic", {p, p + 4}), {0.1f}));
  const Mesh bezier = tube(with_widths(curves("cubic", "bezier", "nonperiodic",
                                              {(p[0] + p[1] * 4.0f + p[2]) / 6.0f, (p[1] * 2.0f + p[2]) / 3.0f,
                                               (p[1] + p[2] * 2.0f) / 3.0f, (p[1] + p[2] * 4.0f + p[3]) / 6.0f}),
                                       {0.1f}));
  ASSERT_EQ(spline.points.size(), bezier.points.size());
  for (size_t i = 0; i < spline.points.size(); ++i)
    EXPECT_LT((spline.points[i] - bezier.points[i]).length(), 1e-5f) << i;
  for (const char* basis : {"bspline", "catmullRom"}) {
    const Mesh pinned = tube(with_widths(curves("cubic", basis, "pinned", {p, p + 4}), {0.001f}));
    const auto nearest = [&](const Vec3f& to) {
      float least = 1e9f;
      for (const Vec3f& q : pinned.points) least = std::min(least, (q - to).length());
      return least;
    };
    EXPECT_LT(nearest(p[0]), 0.001f) << basis;
    EXPECT_LT(nearest(p[3]), 0.001f) << basis;
  }
  const Mesh through = tube(with_widths(curves("cubic", "catmullRom", "nonperiodic", {p, p + 4}), {0.001f}));
  EXPECT_LT(std::abs(measure(through).volume), measure(bezier).volume) << "a part of the curve alone";
}

// A closed curve in space: its frame comes back turned, and the turn is shared.
TEST(Curves, AClosedCurveInSpaceIsNoTwistedTube) {
  std::vector<Vec3f> knot;
  for (int i = 0; i < 24; ++i) {
    const double t = 2 * kPi * i / 24;
    knot.emplace_back(Vec3d(std::sin(t) + 2 * std::sin(2 * t), std::cos(t) - 2 * std::cos(2 * t), -std::sin(3 * t)));
  }
  const Mesh mesh = tube(with_widths(curves("cubic", "bspline", "periodic", knot), {0.2f}));
  expect_solid(mesh, "knot");
  double length = 0, longest = 0;
  const size_t rings = mesh.points.size() / 12;
  std::vector<Vec3d> centres(rings, Vec3d(0));
  for (size_t i = 0; i < mesh.points.size(); ++i) centres[i / 12] += Vec3d(mesh.points[i]) / 12;
  for (size_t i = 0; i < rings; ++i) {
    const double step = (centres[(i + 1) % rings] - centres[i]).length();
    length += step;
    for (size_t k = 0; k < 12; ++k)
      longest = std::max(
          longest, (Vec3d(mesh.points[(i + 1) % rings * 12 + k]) - Vec3d(mesh.points[i * 12 + k])).length() - step);
  }
  EXPECT_NEAR(measure(mesh).volume, kPi * 0.01 * length, 0.01 * kPi * 0.01 * length);
  EXPECT_LT(longest, 0.03) << "no side leaves its place from one ring to the next";
}

// promise: usd.curves.points
TEST(Curves, PointsAreSpheresWithinAThousandthOfTheirRadius) {
  prims::PulledMesh shape;
  prims::make_sphere_of(&shape);
  const Mesh sphere = build(shape);
  expect_solid(sphere, "sphere");
  EXPECT_NEAR(measure(sphere).volume, 4 * kPi / 3, 1e-5);
  for (const auto& [a, b, c] : sphere.triangles) {
    const Vec3f centre = (sphere.points[a] + sphere.points[b] + sphere.points[c]) / 3.0f;
    for (const Vec3f& p : {sphere.points[a], (sphere.points[a] + sphere.points[b]) / 2.0f, centre})
      ASSERT_NEAR(p.length(), 1, 1e-3);
  }
}

host::MeshDescription points(std::vector<Vec3f> places, std::vector<float> widths) {
  host::MeshDescription prim;
  prim.type = "points";
  prim.primvars["points"].value = Array<Vec3f>(std::move(places));
  return with_widths(std::move(prim), std::move(widths), Interpolation::vertex);
}

std::vector<float> picture(Stage& stage, const char* aov, int size) {
  RenderBuffer* const buffer = stage.add_buffer("/buffer", size, size, Format::float32vec4);
  const auto pass = stage.delegate->CreateRenderPass();
  stage.index->SyncAll();
  EXPECT_TRUE(Stage::finish(*pass, Stage::state_for(size, size, aov, buffer)));
  return Stage::pixels<float>(buffer);
}

// Beside spheres that stand there as instances of a mesh.
TEST(Curves, PointsStandWhereTheyAreUnderTheirInstancerToo) {
  Stage stage({{"samples", 4}});
  stage.add_basic_scene();
  stage.scene.Remove("/quad");
  host::MeshDescription cloud = points({{-0.4f, 0, 0}, {0.5f, 0.2f, 0}, {9, 9, 9}}, {0.4f, 0.8f, 0});
  cloud.transform.setTranslation(Vec3d(0, 0.3, 0));
  cloud.instancer = "/pair";
  host::InstancerDescription pair;
  pair.primvars["hydra:instanceTranslations"] = Array<Vec3f>{{0, 0, 0}, {0, -1, 0}};
  pair.indices["/cloud"] = {0, 1};
  stage.scene.SetInstancer("/pair", pair);
  stage.scene.SetMesh("/cloud", cloud);
  const std::string dump = stage.dump();
  EXPECT_EQ(stage.take_diagnostics().size(), 0u);
  const std::vector<float> drawn = picture(stage, "color", 32);
  stage.scene.Remove("/cloud");
  stage.scene.Remove("/pair");
  prims::PulledMesh shape;
  prims::make_sphere_of(&shape);
  for (int i = 0; i < 4; ++i) {
    host::MeshDescription sphere;
    sphere.topology = shape.topology;
    sphere.primvars["points"].value = shape.points.value;
    sphere.primvars["normals"].value = shape.normals.value;
    const double radius = i % 2 ? 0.4 : 0.2;
    sphere.transform = Matrix4d().setScale(Vec3d(radius)) *
                       Matrix4d().setTranslation(Vec3d(i % 2 ? 0.5 : -0.4, (i % 2 ? 0.5 : 0.3) - i / 2, 0));
    stage.scene.SetMesh("/sphere" + std::to_string(i), sphere);
  }
  const std::vector<float> wanted = picture(stage, "color", 32);
  double apart = 0, sum = 0;
  for (size_t i = 0; i < drawn.size(); ++i)
    apart += std::abs(double(drawn[i]) - double(wanted[i])), sum += double(wanted[i]);
  EXPECT_GT(sum, 10);
  EXPECT_LT(apart, 0.02 * sum);
  size_t named = 0;
  for (size_t at = dump.find("instance /cloud prim "); at != std::string::npos;
       at = dump.find("instance /cloud prim ", at + 1))
    ++named;
  EXPECT_EQ(named, 4u) << "two points in two places, by the name of their prim: " << dump;
}

// Beside instances of one sphere, which have the values by instance: to the bit.
// promise: usd.curves.points_values
TEST(Curves, PointsHaveValuesOfTheirOwn) {
  Stage stage({{"samples", 4}});
  stage.add_basic_scene();
  stage.scene.Remove("/quad");
  host::CameraDescription camera = stage.scene.GetCameras().at("/camera");
  camera.parameters["shutterOpen"] = 0.0f, camera.parameters["shutterClose"] = 1.0f;
  stage.scene.SetCamera("/camera", camera);
  MaterialNetwork network;
  network.nodes["/look/tint"] = {"AlabasterPrimvar", {{"varname", Token("tint")}}, {}};
  network.nodes["/look/surface"] = {"AlabasterDisney", {}, {{"baseColor", {{"/look/tint", "rgb"}}}}};
  network.terminals["surface"] = {"/look/surface", "out"};
  stage.scene.SetMaterial("/look", network);
  prims::PulledMesh shape;
  prims::make_sphere_of(&shape);
  host::MeshDescription sphere;
  sphere.topology = shape.topology;
  sphere.primvars["points"].value = shape.points.value, sphere.primvars["normals"].value = shape.normals.value;
  sphere.instancer = "/row";

  const Array<Vec3f> places{{-1, 0, 0}, {9, 9, 9}, {0, 0.3f, 0}, {1, -0.4f, 0}};
  const Array<Vec3f> later{{-1, 0.8f, 0}, {9, 9, 9}, {0.5f, 0.3f, 0}, {1, -1, 0}};
  std::vector<float> before;
  for (const bool moves : {false, true})
    for (const char* primvar : {"displayColor", "tint"})
      for (const std::vector<float>& widths : {std::vector<float>{0.6f, 0, 0.9f, 1.2f}, {1.2f, 0, 0.5f, 0.3f}}) {
        host::MeshDescription cloud = points({places.begin(), places.end()}, widths);
        cloud.material = sphere.material = primvar == std::string("tint") ? Path("/look") : Path();
        const Array<Vec3f> tints{{0.8f, 0.1f, 0.1f}, {0.1f, 0.7f, 0.2f}, {0.1f, 0.2f, 0.9f}};
        cloud.primvars[primvar] = {Interpolation::vertex, "color", tints, {2, 0, 1, 0}};
        host::InstancerDescription row;
        std::vector<Vec3f> scales;
        for (const float width : widths) scales.emplace_back(width / 2);
        row.primvars["hydra:instanceTranslations"] = places;
        row.primvars["hydra:instanceScales"] = Array<Vec3f>(std::move(scales));
        row.primvars[primvar] = Array<Vec3f>{tints[2], tints[0], tints[1], tints[0]};
        row.indices["/cloud"] = {0, 2, 3};
        if (moves) {
          cloud.primvarSamples["points"] = {{0, 1}, {places, later}};
          row.primvarSamples["hydra:instanceTranslations"] = {{0, 1}, {places, later}};
        }
        const std::string which = primvar + std::string(moves ? " moves" : "") + std::to_string(widths[0]);
        stage.scene.SetMesh("/cloud", cloud);
        const std::vector<float> drawn = picture(stage, "color", 32);
        EXPECT_EQ(stage.take_diagnostics().size(), 0u) << which;
        EXPECT_NE(drawn, before) << which;
        stage.scene.Remove("/cloud");
        stage.scene.SetInstancer("/row", row);
        stage.scene.SetMesh("/cloud", sphere);
        EXPECT_EQ(drawn, picture(stage, "color", 32)) << which;
        stage.scene.Remove("/cloud"), stage.scene.Remove("/row");
        before = drawn;
      }
}

TEST(Curves, PointsAreEditedAndRemoved) {
  Stage stage({{"samples", 1}});
  stage.add_basic_scene();
  stage.scene.Remove("/quad");
  const auto coverage = [&] {
    const std::vector<float> alpha = picture(stage, "color", 16);
    double sum = 0;
    for (size_t i = 3; i < alpha.size(); i += 4) sum += double(alpha[i]);
    return sum;
  };
  host::LightDescription dark{.type = "domeLight", .transform = {}, .parameters = {{"visibleToCamera", false}}};
  stage.scene.SetLight("/dome", dark);
  stage.scene.SetMesh("/cloud", points({{0, 0, 0}}, {1}));
  const double one = coverage();
  EXPECT_GT(one, 5);
  stage.scene.SetMesh("/cloud", points({{-1, -1, 0}, {1, 1, 0}}, {1, 1}));
  EXPECT_GT(coverage(), 1.5 * one);
  stage.scene.Remove("/cloud");
  EXPECT_EQ(coverage(), 0);
}

// A white body that scatters in a white room shows white: light neither leaks out of the tube nor is lost in it.
TEST(Curves, AWhiteTubeThatScattersIsAFurnace) {
  Stage stage({{"samples", 256}});
  stage.add_basic_scene();
  stage.scene.Remove("/quad");
  stage.set_surface("/white", {{"baseColor", Vec3f(1)}, {"scatterDistance", Vec3f(0.1f)}, {"specular", 0.0f}});
  host::MeshDescription hair = with_widths(
      curves("cubic", "bspline", "pinned", {{-1.2f, -1, 0}, {-0.5f, 0.5f, 0.2f}, {0.5f, -0.8f, 0}, {1, 1, -0.3f}}),
      {0.8f, 0.5f, 0.3f, 0}, Interpolation::vertex);
  hair.material = "/white";
  stage.scene.SetMesh("/hair", hair);
  const std::vector<float> seen = picture(stage, "color", 16);
  double light = 0, covered = 0;
  for (size_t i = 0; i < seen.size(); ++i) (i % 4 < 3 ? light : covered) += double(seen[i]);
  EXPECT_GT(covered, 20);
  EXPECT_NEAR(light / (3 * covered), 1, 0.005);
}

// Two curves that are seen from the front, left and right.
struct TwoCurves {
  explicit TwoCurves(Dictionary settings = {{"samples", 16}}) : stage(settings) {
    stage.add_basic_scene();
    stage.scene.Remove("/quad");
    prim = with_widths(
        curves("cubic", "bezier", "nonperiodic",
               {{-1, -2, 0}, {-1, -1, 0}, {-1, 1, 0}, {-1, 2, 0}, {1, -2, 0}, {1, -1, 0}, {1, 1, 0}, {1, 2, 0}},
               {4, 4}),
        {1});
  }
  void set_colors(Interpolation interpolation, std::vector<Vec3f> colors, Array<int32_t> indices = {}) {
    prim.primvars["displayColor"] = {interpolation, "color", Array<Vec3f>(std::move(colors)), std::move(indices)};
  }
  /// At a place of the picture of 16 pixels a side.
  Vec4f pixel(const char* aov, int x, int y) {
    stage.scene.SetMesh("/hair", prim);
    const std::vector<float> all = picture(stage, aov, 16);
    const float* c = &all[static_cast<size_t>((y * 16 + x) * 4)];
    return Vec4f(c[0], c[1], c[2], c[3]);
  }
  Vec3f at(int x, int y) {
    const Vec4f albedo = pixel("albedo", x, y);
    return Vec3f(albedo.x, albedo.y, albedo.z);
  }
  Stage stage;
  host::MeshDescription prim;
};

// promise: usd.curves.values
TEST(Curves, ValuesByCurveByPointAndByEndOfASegmentAreWhereTheyBelong) {
  TwoCurves two;
  two.set_colors(Interpolation::uniform, {{1, 0, 0}, {0, 1, 0}}, {1, 0});
  // The rest of the albedo is that of a dielectric's reflection, 4 %.
  EXPECT_LT((two.at(4, 8) - Vec3f(0, 1, 0)).length(), 0.06f) << two.at(4, 8);
  EXPECT_LT((two.at(11, 8) - Vec3f(1, 0, 0)).length(), 0.06f) << two.at(11, 8);
  two.set_colors(Interpolation::varying, {{0, 0, 0}, {1, 1, 1}, {0, 0, 0}, {0, 0, 0}});
  EXPECT_NEAR(two.at(4, 4).x, 0.71, 0.03) << "the curve runs from below to above";
  EXPECT_NEAR(two.at(4, 12).x, 0.30, 0.04);
  EXPECT_NEAR(two.at(11, 4).x, 0.04, 0.001);
  two.set_colors(Interpolation::vertex,
                 {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {1, 1, 1}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}});
  EXPECT_NEAR(two.at(4, 4).x, 0.375, 0.03) << "by the basis: the cube of .7, beside 4 %";
}

// promise: usd.curves.motion
TEST(Curves, TheyMoveWithinTheShutter) {
  TwoCurves two;
  host::CameraDescription camera = two.stage.scene.GetCameras().at("/camera");
  camera.parameters["shutterOpen"] = 0.0f, camera.parameters["shutterClose"] = 1.0f;
  two.stage.scene.SetCamera("/camera", camera);
  const auto* still = two.prim.primvars["points"].value.get<Array<Vec3f>>();
  std::vector<Vec3f> moved;
  for (const Vec3f& p : *still) moved.push_back(p + Vec3f(p.x > 0 ? 0.8f : 0, 0, 0));
  two.prim.primvarSamples["points"] = {{0, 1}, {*still, Array<Vec3f>(moved)}};
  const float at_rest = two.pixel("color", 4, 8).w, blurred = two.pixel("color", 15, 8).w;
  EXPECT_NEAR(at_rest, 1, 0.01);
  EXPECT_GT(blurred, 0.2f);
  EXPECT_LT(blurred, 0.9f);
  EXPECT_EQ(two.stage.take_diagnostics().size(), 0u);
}

// promise: usd.curves.faults
TEST(Curves, BadInputIsNamedAndTheRestIsDrawn) {
  const auto said = [](const host::MeshDescription& prim) {
    Stage stage({{"samples", 1}});
    stage.add_basic_scene();
    stage.scene.SetMesh("/hair", prim);
    stage.index->SyncAll();
    std::string all;
    for (const Diagnostic& d : stage.take_diagnostics()) all += d.where + ": " + d.text + "\n";
    return all;
  };
  const std::vector<Vec3f> line{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(said(curves("linear", "bezier", "nonperiodic", line)), "");
  EXPECT_EQ(said(curves("linear", "bezier", "nonperiodic", line, {2, 4})),
            "/hair: curveVertexCounts add up to 6, and there are 3 points; curves beyond the points are not drawn\n");
  EXPECT_EQ(said(curves("linear", "bezier", "nonperiodic", line, {2})),
            "/hair: curveVertexCounts add up to 2, and there are 3 points; points beyond the curves are not used\n");
  EXPECT_EQ(said(curves("cubic", "bezier", "nonperiodic", line)),
            "/hair: 1 curves have too few points for a segment, and are not drawn (first: curve 0)\n");
  EXPECT_EQ(said(curves("linear", "bezier", "nonperiodic", {{1, 1, 1}, {1, 1, 1}, {0, 0, 0}, {1, 0, 0}}, {2, 2})),
            "/hair: 1 curves have all points in one place, and are not drawn (first: curve 0)\n");
  EXPECT_EQ(said(curves("linear", "bezier", "nonperiodic", {{0, 0, 0}, {1, 0, 0}, {0, nan, 0}, {1, 0, 0}}, {2, 2})),
            "/hair: 1 curves have points that are not finite or beyond 1e17, and are not drawn (first: curve 1)\n");
  EXPECT_EQ(said(with_widths(curves("linear", "bezier", "nonperiodic", line), {1, 2}, Interpolation::vertex)),
            "/hair: widths of curves has 2 values, and 3 are needed (one per point); 1 is used\n");
  EXPECT_EQ(said(with_widths(curves("linear", "bezier", "nonperiodic", line), {1, -1, nan}, Interpolation::vertex)),
            "/hair: 2 widths of curves are negative, not finite or beyond 1e17; 0 is used (first: width 1)\n");
  EXPECT_EQ(said(curves("cubic", "hermite", "pinned", line)),
            "/hair: basis 'hermite' of curves is not known; bezier is used\n"
            "/hair: 1 curves have too few points for a segment, and are not drawn (first: curve 0)\n");
  EXPECT_EQ(said(curves("cubic", "bezier", "nonperiodic", {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {4, 0, 0}})),
            "/hair: 1 curves have points beyond their last segment, which are not used (first: curve 0)\n");
  // Counts whose segments are more than 2^32 together.
  host::MeshDescription endless =
      curves("cubic", "bspline", "nonperiodic", std::vector<Vec3f>(103, {0, 0, 0}), {103, 2147483647, 2147483647});
  endless.primvars["displayColor"] = {
      Interpolation::varying, "color", Array<Vec3f>(std::vector<Vec3f>(95, {1, 0, 0})), {}};
  EXPECT_NE(said(endless).find("has 95 values, and 4294967391 are needed"), std::string::npos) << said(endless);
  const float line_radius = 0.1f;
  EXPECT_NEAR(measure(tube(with_widths(curves("linear", "bezier", "nonperiodic",
                                              {{0, 0, 0}, {1, 0, 0}, {0, nan, 0}, {1, 0, 0}}, {2, 2}),
                                       {2 * line_radius})))
                  .volume,
              kPi * line_radius * line_radius, 1e-4);
  host::MeshDescription ribbon = curves("linear", "bezier", "nonperiodic", line);
  ribbon.primvars["normals"].value = Array<Vec3f>{{0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
  EXPECT_EQ(said(ribbon), "/hair: normals make ribbons of curves; they are drawn as tubes\n");
  EXPECT_EQ(said(points({{0, 0, 0}, {1, 0, 0}}, {1, -1})),
            "/hair: 1 points have no finite place, or a width that is negative or not finite; they are not drawn\n");
  EXPECT_EQ(said(points({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {1, 1})),
            "/hair: widths of points must be one number, or one for each of the 3 points; 1 is used\n");
  host::MeshDescription indexed = points({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {1, 2});
  indexed.primvars["widths"].indices = {1, 0, 1};
  EXPECT_EQ(said(indexed), "");
  indexed.primvars["widths"].indices = {1, 0, 2};
  EXPECT_EQ(said(indexed), "/hair: widths of points must be one number, or one for each of the 3 points; 1 is used\n");
  host::MeshDescription warm = points({{0, 0, 0}, {1, 0, 0}}, {1, 1});
  warm.primvars["heat"] = {Interpolation::vertex, {}, Array<float>{1, 2}, {}};
  EXPECT_EQ(said(warm), "");
  warm.primvars["heat"].value = Array<float>{1, 2, 3};
  EXPECT_EQ(said(warm), "/hair: primvar heat has 3 values, 2 are needed (one per point); ignored\n");
}

// promise: usd.curves.memory
TEST(Curves, TooManyAreRefusedBeforeTheyAreMade) {
  Drawing drawing(64);
  std::vector<Vec3f> points;
  for (int i = 0; i < 400000; ++i) points.emplace_back(float(i % 640) * 0.01f, float(i / 640) * 0.01f, float(i % 2));
  drawing.stage.scene.SetMesh(
      "/hair",
      with_widths(curves("linear", "bezier", "nonperiodic", points, std::vector<int32_t>(200000, 2)), {0.01f}));
  EXPECT_FALSE(drawing.draw());
  const std::string errors = drawing.errors();
  EXPECT_EQ(errors.find("/hair: a mesh of the tubes of 200000 curve segments needs "), 0u) << errors;
  EXPECT_NE(errors.find("of the memory limit of 64 MiB"), std::string::npos) << errors;
}

}  // namespace
}  // namespace alabaster::hd
