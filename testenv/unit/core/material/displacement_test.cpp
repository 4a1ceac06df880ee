#include "core/material/displacement.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <map>

#include "core/math/frame.h"
#include "testenv/support/cages.h"
#include "testenv/support/memory_texture.h"
#include "testenv/support/scene_builder.h"

namespace alabaster {
namespace {

using testing::MemoryTexture;

// A function of uv, exact at every point.
class Formula : public Texture {
 public:
  explicit Formula(std::function<Rgb(const Vec2f&)> value) : value_(std::move(value)) {}
  Rgb rgb(const Vec2f& uv) const override { return value_(uv); }
  int width() const override { return 1; }
  int height() const override { return 1; }
  size_t memory_bytes() const override { return 0; }
  Rgb texel(int, int) const override { return value_({0, 0}); }

 private:
  std::function<Rgb(const Vec2f&)> value_;
};

Displacement by(std::function<Rgb(const Vec2f&)> value, DisplacementSpace space = DisplacementSpace::normal) {
  Displacement d;
  d.texture.image = std::make_shared<Formula>(std::move(value));
  d.space = space;
  d.channel = space == DisplacementSpace::normal ? Channel::r : Channel::rgb;
  return d;
}

Mesh build(const Cage& cage, int level, const Displacements& displacements, const DiagnosticSink& sink = {}) {
  RefinementOptions options;
  options.level = level;
  options.where = "/mesh";
  options.displace = [&](Mesh* mesh) { displace(displacements, options.where, sink, mesh); };
  return build_mesh(cage, options, sink);
}
Mesh refined(const Cage& cage, int level) {
  RefinementOptions options;
  options.level = level;
  return build_mesh(cage, options, {});
}

// Texture coordinates that are the points' x and y, from 0 to 1.
void add_plane_uvs(Cage* cage, float size) {
  UvPrimvar uv;
  uv.name = "st";
  for (const Vec3f& p : cage->points) uv.values.emplace_back(p.x / size, p.y / size);
  cage->uvs = {uv};
}

// Each face of a cube has the whole square.
Cage cube_with_seams(SubdivisionScheme scheme) {
  Cage cage = test::cube_cage(scheme);
  UvPrimvar uv;
  uv.name = "st";
  uv.interpolation = Interpolation::face_varying;
  for (int face = 0; face < 6; ++face) {
    const float x = static_cast<float>(face) / 6;
    for (const Vec2f& corner : {Vec2f(x, 0), Vec2f(x + 0.16f, 0), Vec2f(x + 0.16f, 1), Vec2f(x, 1)})
      uv.values.push_back(corner);
  }
  cage.uvs = {uv};
  return cage;
}

float ridges(const Vec2f& uv) {
  return 0.05f * std::sin(40 * uv.x) * std::cos(17 * uv.y);
}

TEST(Displacement, ConstantHeightMakesASphereLarger) {
  for (const bool smooth : {true, false}) {
    const Mesh sphere = testing::sphere_mesh(2, 24, smooth);
    Displacement d = by([](const Vec2f&) { return Rgb(0.75f, 9, 9); });
    d.scale = 2, d.midlevel = 0.25f;
    Mesh displaced = sphere;
    displace({d}, "/mesh", {}, &displaced);
    ASSERT_EQ(displaced.triangles, sphere.triangles);
    // The mean normal of facets is not quite radial.
    const float tolerance = smooth ? 1e-5f : 2e-2f;
    for (size_t i = 0; i < sphere.points.size(); ++i) {
      const Vec3f wanted = sphere.points[i] * 1.5f;
      EXPECT_LT(length(displaced.points[i] - wanted), 3 * tolerance) << i;
      if (smooth) {
        EXPECT_LT(length(displaced.normals[i] - normalize(sphere.points[i])), 1e-4f) << i;
      }
    }
    EXPECT_EQ(displaced.normals.empty(), !smooth);
  }
}

// z = a sin(k x) sin(k y) over the unit square has the normal (-dz/dx, -dz/dy, 1), and the recomputed ones converge to
// it with the square of the distance between points.
TEST(Displacement, NormalsOfADisplacedPlaneConvergeToTheAnalyticOnes) {
  Cage cage = test::grid_cage(4, SubdivisionScheme::catmull_clark);
  for (Vec3f& p : cage.points) p = p * 0.25f;
  add_plane_uvs(&cage, 1);
  constexpr float a = 0.05f, k = 9;
  const Displacement d = by([](const Vec2f& uv) { return Rgb(a * std::sin(k * uv.x) * std::sin(k * uv.y)); });
  double worst[2] = {0, 0};
  for (const int level : {4, 5}) {
    const Mesh mesh = build(cage, level, {d});
    for (size_t t = 0; t < mesh.triangles.size(); ++t)
      for (size_t i = 0; i < 3; ++i) {
        const Vec3f& p = mesh.points[mesh.triangles[t][i]];
        ASSERT_NEAR(p.z, a * std::sin(k * p.x) * std::sin(k * p.y), 1e-5f);
        if (std::min({p.x, p.y, 1 - p.x, 1 - p.y}) < 0.02f) continue;  // one-sided at the border
        const Vec3f wanted = normalize(
            Vec3f(-a * k * std::cos(k * p.x) * std::sin(k * p.y), -a * k * std::sin(k * p.x) * std::cos(k * p.y), 1));
        const Corners& normals = mesh.normal_triangles.empty() ? mesh.triangles[t] : mesh.normal_triangles[t];
        worst[level - 4] = std::max(worst[level - 4], double(length(mesh.normals[normals[i]] - wanted)));
      }
  }
  EXPECT_LT(worst[0], 0.02);
  EXPECT_LT(worst[1], 0.55 * worst[0]);
}

// A closed body stays closed, whatever its texture says on the two sides of a seam, and winds as before.
TEST(Displacement, AcrossSeamsOfTheTextureBodiesStayClosed) {
  for (const SubdivisionScheme scheme :
       {SubdivisionScheme::none, SubdivisionScheme::catmull_clark, SubdivisionScheme::bilinear}) {
    const Cage cage = cube_with_seams(scheme);
    const int level = scheme == SubdivisionScheme::none ? 0 : 4;
    const Mesh mesh = build(cage, level, {by([](const Vec2f& uv) { return Rgb(ridges(uv) + 0.2f * uv.x); })});
    const Mesh before = refined(cage, level);
    EXPECT_TRUE(mesh.closed);
    EXPECT_TRUE(mesh.outward);
    EXPECT_EQ(mesh.triangles, before.triangles);
    EXPECT_NE(mesh.points, before.points);
  }
}

// Files split points at seams: points that coincide do so afterwards.
TEST(Displacement, PointsThatAFileHadToSplitStayTogether) {
  const Cage shared = cube_with_seams(SubdivisionScheme::none);
  Cage split = shared;
  split.points.clear();
  split.face_vertex_indices.clear();
  for (const int i : shared.face_vertex_indices) {
    split.face_vertex_indices.push_back(static_cast<int>(split.points.size()));
    split.points.push_back(shared.points[static_cast<size_t>(i)]);
  }
  const Displacements d{by([](const Vec2f& uv) { return Rgb(0.3f * uv.x + 0.1f * uv.y); })};
  const Mesh a = build(split, 0, d), b = build(shared, 0, d);
  EXPECT_TRUE(a.closed);
  for (size_t t = 0; t < a.triangles.size(); ++t)
    for (size_t i = 0; i < 3; ++i) EXPECT_LT(length(a.points[a.triangles[t][i]] - b.points[b.triangles[t][i]]), 1e-6f);
}

// Hard edges stay hard: a cube's faces keep normals of their own.
TEST(Displacement, HardEdgesStayHard) {
  Cage cage = cube_with_seams(SubdivisionScheme::bilinear);
  const Mesh mesh = build(cage, 3, {by([](const Vec2f&) { return Rgb(0.1f); })});
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto point = [&](size_t i) { return mesh.points[mesh.triangles[t][i]]; };
    const Vec3f facet = normalize(cross(point(1) - point(0), point(2) - point(0)));
    for (size_t i = 0; i < 3; ++i)
      EXPECT_GT(dot(mesh.normals[mesh.normal_triangles[t][i]], facet), 0.9f);  // smoothed: 0.7
  }
}

// On a refined plane, u runs along y and v along -x: tangent space turns with the coordinates, object space does not.
TEST(Displacement, VectorsAreInTangentOrObjectSpace) {
  Cage cage = test::grid_cage(2, SubdivisionScheme::catmull_clark);
  UvPrimvar uv;
  uv.name = "st";
  for (const Vec3f& p : cage.points) uv.values.emplace_back(p.y, -p.x);
  cage.uvs = {uv};
  const auto vector = [](const Vec2f&) { return Rgb(0.1f, 0.02f, 0.3f); };
  const Mesh before = refined(cage, 3);
  const Mesh tangent = build(cage, 3, {by(vector, DisplacementSpace::tangent)});
  const Mesh object = build(cage, 3, {by(vector, DisplacementSpace::object)});
  for (size_t i = 0; i < before.points.size(); ++i) {
    EXPECT_LT(length(tangent.points[i] - before.points[i] - Vec3f(-0.02f, 0.1f, 0.3f)), 1e-5f);
    EXPECT_LT(length(object.points[i] - before.points[i] - Vec3f(0.1f, 0.02f, 0.3f)), 1e-5f);
  }
  // Mirrored coordinates: across follows growing v.
  for (Vec2f& st : cage.uvs[0].values) st.y = -st.y;
  const Mesh mirrored = build(cage, 3, {by(vector, DisplacementSpace::tangent)});
  for (size_t i = 0; i < before.points.size(); ++i)
    EXPECT_LT(length(mirrored.points[i] - before.points[i] - Vec3f(0.02f, 0.1f, 0.3f)), 1e-5f);
}

// Rays against the displaced body find what a mesh finds that the test displaces itself, and on the sphere their
// distances are those of the formula.
TEST(Displacement, TracesAsAMeshThatIsDisplacedByHand) {
  const Mesh sphere = testing::sphere_mesh(1, 48, true);
  Mesh displaced = sphere;
  displaced.uv_sets.push_back({{}, "st"});
  for (const Vec3f& p : sphere.points) displaced.uv_sets[0].values.emplace_back(p.y, p.x * p.z);
  const auto height = [](const Vec2f& uv) { return 0.2f * std::sin(5 * uv.x) + 0.1f * uv.y; };
  Mesh by_hand = sphere;
  for (Vec3f& p : by_hand.points) p = p + normalize(p) * height({p.y, p.x * p.z});
  displace({by([&](const Vec2f& uv) { return Rgb(height(uv)); })}, "/mesh", {}, &displaced);
  const auto device = make_trace_device({});
  const auto a = build_object_scene(device, displaced, {}), b = build_object_scene(device, by_hand, {});
  int hits = 0;
  for (int i = 0; i < 2000; ++i) {
    const float z = 1 - 2 * (static_cast<float>(i) + 0.5f) / 2000, angle = 2.39996f * static_cast<float>(i);
    const float r = std::sqrt(1 - z * z);
    const Vec3f d(r * std::cos(angle), r * std::sin(angle), z);
    TriangleHit ha, hb;
    ASSERT_TRUE(a->intersect({Vec3f(0, 0, 0), d}, &ha));
    ASSERT_TRUE(b->intersect({Vec3f(0, 0, 0), d}, &hb));
    EXPECT_NEAR(ha.t, hb.t, 1e-4f);
    EXPECT_NEAR(ha.t, 1 + height({d.y, d.x * d.z}), 0.01f);
    ++hits;
  }
  EXPECT_EQ(hits, 2000);
}

TEST(Displacement, PointsSharedByMaterialsTakeTheMean) {
  Cage cage = test::grid_cage(2);
  add_plane_uvs(&cage, 2);
  cage.face_material = {0, 1, 0, 1};
  const Mesh mesh = build(cage, 0, {std::nullopt, by([](const Vec2f&) { return Rgb(1.0f); })});
  for (size_t i = 0; i < mesh.points.size(); ++i) {
    const float x = cage.points[i].x;
    EXPECT_NEAR(mesh.points[i].z, x / 2, 1e-6f) << x;  // 0, one half on the border, 1
  }
}

TEST(Displacement, NonFiniteDisplacementIsAnErrorAndLeavesPoints) {
  Cage cage = test::grid_cage(2);
  add_plane_uvs(&cage, 2);
  for (const float value : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), 1e30f}) {
    test::RecordingSink reports;
    const Mesh mesh =
        build(cage, 0, {by([&](const Vec2f& uv) { return Rgb(uv.x > 0.9f ? value : 0.5f); })}, reports.sink());
    ASSERT_TRUE(reports.has("mesh.displacement.nonfinite"));
    for (const Diagnostic& d : reports.all()) EXPECT_EQ(d.severity, Severity::error);
    for (size_t i = 0; i < mesh.points.size(); ++i)
      EXPECT_EQ(mesh.points[i].z, cage.points[i].x > 1.8f ? 0 : 0.5f) << i;
  }
}

TEST(Displacement, WithoutTextureCoordinatesReadsTheTextureAtTheOriginAndWarns) {
  test::RecordingSink reports;
  const Cage cage = test::grid_cage(2);
  const Mesh mesh = build(cage, 0, {by([](const Vec2f& uv) { return Rgb(1 + uv.x); })}, reports.sink());
  ASSERT_TRUE(reports.has("mesh.displacement.uvs"));
  for (const Vec3f& p : mesh.points) EXPECT_EQ(p.z, 1);
}

}  // namespace
}  // namespace alabaster
