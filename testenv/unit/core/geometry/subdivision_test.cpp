#include <gtest/gtest.h>
#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/far/topologyRefinerFactory.h>
#include <tbb/global_control.h>

#include <memory>
#include <tuple>

#include "core/geometry/mesh.h"
#include "testenv/support/cages.h"
#include "testenv/support/same_bytes.h"

namespace alabaster {
namespace {

namespace Far = OpenSubdiv::Far;
namespace Sdc = OpenSubdiv::Sdc;
using testing::same_bytes;

Mesh refine(const Cage& cage, int level) {
  RefinementOptions options;
  options.level = level;
  return build_mesh(cage, options, {});
}

// A point for OpenSubdiv's primvar refiner.
struct Value {
  Vec3f p{0, 0, 0};
  void Clear(void* = nullptr) { p = Vec3f(0, 0, 0); }
  void AddWithWeight(const Value& v, float w) { p += v.p * w; }
};

struct Limit {
  std::vector<Value> p, du, dv;
};

// OpenSubdiv's other evaluator as oracle: uniform refinement, then the limit masks.
Limit far_limit(const Cage& cage, int level) {
  Far::TopologyDescriptor topology;
  topology.numVertices = static_cast<int>(cage.points.size());
  topology.numFaces = static_cast<int>(cage.face_vertex_counts.size());
  topology.numVertsPerFace = cage.face_vertex_counts.data();
  topology.vertIndicesPerFace = cage.face_vertex_indices.data();
  topology.numCreases = static_cast<int>(cage.crease_sharpnesses.size());
  topology.creaseVertexIndexPairs = cage.crease_indices.data();
  topology.creaseWeights = cage.crease_sharpnesses.data();
  topology.numCorners = static_cast<int>(cage.corner_indices.size());
  topology.cornerVertexIndices = cage.corner_indices.data();
  topology.cornerWeights = cage.corner_sharpnesses.data();
  Sdc::Options options;
  options.SetVtxBoundaryInterpolation(cage.boundary_rule == BoundaryRule::edge_only
                                          ? Sdc::Options::VTX_BOUNDARY_EDGE_ONLY
                                          : Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER);
  using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
  const auto scheme = cage.scheme == SubdivisionScheme::loop ? Sdc::SCHEME_LOOP : Sdc::SCHEME_CATMARK;
  const std::unique_ptr<Far::TopologyRefiner> refiner(Factory::Create(topology, Factory::Options(scheme, options)));
  Far::TopologyRefiner::UniformOptions uniform(level);
  uniform.fullTopologyInLastLevel = true;
  refiner->RefineUniform(uniform);
  const Far::PrimvarRefiner primvars(*refiner);
  std::vector<Value> values;
  for (const Vec3f& p : cage.points) values.push_back({p});
  for (int i = 1; i <= level; ++i) {
    std::vector<Value> finer(static_cast<size_t>(refiner->GetLevel(i).GetNumVertices()));
    const Value* coarse = values.data();
    Value* fine = finer.data();
    primvars.Interpolate(i, coarse, fine);
    values = finer;
  }
  Limit limit{values, values, values};
  const Value* last = values.data();
  Value *p = limit.p.data(), *du = limit.du.data(), *dv = limit.dv.data();
  primvars.Limit(last, p, du, dv);
  return limit;
}

// Every limit point of the oracle is a point of the mesh, with the same normal, and there are no others.
// Tangents near extraordinary points are those of Bfr's approximating patches: 8e-4 off at four levels of isolation,
// three times less with each further one (points are exact).
void expect_oracle(const Cage& cage, int level, float tolerance, float normal_tolerance = 1.5e-3f) {
  const Mesh mesh = refine(cage, level);
  const Limit limit = far_limit(cage, level);
  ASSERT_EQ(mesh.points.size(), limit.p.size());
  float worst_point = 0, worst_normal = 0;
  for (size_t i = 0; i < limit.p.size(); ++i) {
    size_t nearest = 0;
    for (size_t k = 1; k < mesh.points.size(); ++k)
      if (length(mesh.points[k] - limit.p[i].p) < length(mesh.points[nearest] - limit.p[i].p)) nearest = k;
    worst_point = std::max(worst_point, length(mesh.points[nearest] - limit.p[i].p));
    if (!mesh.normal_triangles.empty()) continue;
    // No tangent plane to compare where the masks themselves give parallel tangents (a smooth corner of one face).
    const Vec3f du = normalize(limit.du[i].p), dv = normalize(limit.dv[i].p), normal = cross(du, dv);
    if (length(normal) < 0.1f) continue;
    worst_normal = std::max(worst_normal, length(mesh.normals[nearest] - normalize(normal)));
  }
  EXPECT_LT(worst_point, tolerance) << "level " << level;
  EXPECT_LT(worst_normal, normal_tolerance) << "level " << level;
}

Cage skewed(Cage cage) {
  for (Vec3f& p : cage.points) p += Vec3f(0.3f * p.y * p.z, 0.2f * p.x * p.x, 0.1f * p.x - 0.25f * p.y * p.y);
  return cage;
}

void crease_ring(Cage* cage, float sharpness) {
  cage->crease_indices = {4, 5, 5, 7, 7, 6, 6, 4};  // the top of the cube
  cage->crease_lengths = {2, 2, 2, 2};
  cage->crease_sharpnesses.assign(4, sharpness);
}

TEST(Subdivision, CatmullClarkMatchesFarEvaluation) {
  for (int level = 1; level <= 3; ++level) {
    expect_oracle(skewed(test::cube_cage(SubdivisionScheme::catmull_clark)), level, 2e-6f);
    expect_oracle(skewed(test::pentagon_prism_cage(SubdivisionScheme::catmull_clark)), level, 2e-6f);
    expect_oracle(skewed(test::octahedron_cage(SubdivisionScheme::catmull_clark)), level, 2e-6f);
  }
}

TEST(Subdivision, LoopMatchesFarEvaluation) {
  for (int level = 1; level <= 3; ++level)
    expect_oracle(skewed(test::octahedron_cage(SubdivisionScheme::loop)), level, 2e-6f);
}

TEST(Subdivision, BoundariesMatchFarEvaluation) {
  Cage cage = skewed(test::grid_cage(3, SubdivisionScheme::catmull_clark));
  cage.boundary_rule = BoundaryRule::edge_and_corner;
  expect_oracle(cage, 2, 1e-5f);
  // At a smooth corner of one face the derivatives align: the normal is that of the triangle there, O(2^-level) off.
  cage.boundary_rule = BoundaryRule::edge_only;
  for (int level = 2; level <= 4; ++level) expect_oracle(cage, level, 1e-5f, std::ldexp(0.05f, -level));
}

TEST(Subdivision, InfinitelySharpFeaturesMatchFarEvaluation) {
  Cage ring = skewed(test::cube_cage(SubdivisionScheme::catmull_clark));
  crease_ring(&ring, 10);
  expect_oracle(ring, 2, 2e-6f);
  Cage corner = skewed(test::cube_cage(SubdivisionScheme::catmull_clark));
  corner.corner_indices = {7};
  corner.corner_sharpnesses = {10};
  expect_oracle(corner, 2, 2e-6f);
  const Mesh mesh = refine(corner, 1);
  EXPECT_EQ(std::count(mesh.points.begin(), mesh.points.end(), corner.points[7]), 1);
}

TEST(Subdivision, SemiSharpCreasesPullTowardsTheCage) {
  Cage cage = test::cube_cage(SubdivisionScheme::catmull_clark);
  float last = 0;
  for (float sharpness : {0.0f, 0.5f, 1.0f, 2.0f, 3.0f, 5.0f}) {
    crease_ring(&cage, sharpness);
    const Mesh mesh = refine(cage, 3);
    EXPECT_TRUE(mesh.normal_triangles.empty());  // still smooth
    float area = 0;                              // of the top, which grows towards its square
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
      const auto& c = mesh.triangles[t];
      if (mesh.triangle_face[t] == 1)
        area += length(cross(mesh.points[c[1]] - mesh.points[c[0]], mesh.points[c[2]] - mesh.points[c[0]])) / 2;
    }
    EXPECT_GT(area, last * 1.001f);
    EXPECT_LT(area, 4);
    last = area;
  }
}

// Along an infinitely sharp ring each side keeps its own normals; points stay shared.
TEST(Subdivision, NormalsSplitAlongSharpEdges) {
  Cage cage = test::cube_cage(SubdivisionScheme::catmull_clark);
  crease_ring(&cage, 10);
  const Mesh mesh = refine(cage, 3);
  ASSERT_EQ(mesh.normal_triangles.size(), mesh.triangles.size());
  EXPECT_TRUE(mesh.closed);
  for (size_t t = 0; t < mesh.triangles.size(); ++t)
    for (uint32_t n : mesh.normal_triangles[t]) {
      if (mesh.triangle_face[t] == 1) {
        EXPECT_GT(mesh.normals[n].z, 0.999f);  // the top is flat
      } else {
        EXPECT_LT(mesh.normals[n].z, 0.9f);
      }
    }
}

// Closed form: bilinear patches of the cage's own corners; for the unit grid simply multiples of 1/4.
TEST(Subdivision, BilinearIsExact) {
  const Cage cage = test::cube_cage(SubdivisionScheme::bilinear);
  const Mesh mesh = refine(cage, 2);
  EXPECT_EQ(mesh.points.size(), 98u);  // 8 corners, 12 edges of 3, 6 faces of 9
  EXPECT_TRUE(mesh.closed);
  for (const Vec3f& p : mesh.points) {
    EXPECT_EQ(max_abs_component(p), 1);
    for (int i = 0; i < 3; ++i) EXPECT_EQ(p[i] * 2, std::round(p[i] * 2));
  }
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& c = mesh.triangles[t];
    const Vec3f ng = normalize(cross(mesh.points[c[1]] - mesh.points[c[0]], mesh.points[c[2]] - mesh.points[c[0]]));
    for (uint32_t n : mesh.normal_triangles[t]) EXPECT_NEAR(dot(mesh.normals[n], ng), 1, 1e-6f);
  }
}

// A smooth boundary of a uniform grid: cubic B-spline curves. The corner point of edge_only is the end of one.
TEST(Subdivision, BoundaryRulesDifferAsDefined) {
  Cage cage = test::grid_cage(3, SubdivisionScheme::catmull_clark);
  cage.boundary_rule = BoundaryRule::edge_and_corner;
  EXPECT_EQ(refine(cage, 1).bounds.lower, Vec3f(0, 0, 0));
  cage.boundary_rule = BoundaryRule::edge_only;
  const Mesh rounded = refine(cage, 1);
  // The boundary curve through the corner: (1 * (1,0) + 4 * (0,0) + 1 * (0,1)) / 6.
  const Vec3f corner(1.0f / 6, 1.0f / 6, 0);
  EXPECT_TRUE(std::any_of(rounded.points.begin(), rounded.points.end(),
                          [&](const Vec3f& p) { return length(p - corner) < 1e-6f; }));
  cage.boundary_rule = BoundaryRule::none;  // faces at the boundary have no limit
  const Mesh inner = refine(cage, 1);
  EXPECT_EQ(inner.triangles.size(), 8u);
  EXPECT_LT(length(inner.bounds.lower - Vec3f(1, 1, 0)), 1e-6f);
  EXPECT_LT(length(inner.bounds.upper - Vec3f(2, 2, 0)), 1e-6f);
  EXPECT_EQ(inner.triangle_face, std::vector<int32_t>(8, 4));
}

// By the rule `none`, faces at a boundary are not drawn.
TEST(Subdivision, ACageWithoutAnyLimitSurfaceIsEmpty) {
  Cage cage = test::grid_cage(2, SubdivisionScheme::catmull_clark);
  cage.boundary_rule = BoundaryRule::none;
  cage.uvs.resize(1);
  cage.uvs[0].name = "st";
  for (const Vec3f& p : cage.points) cage.uvs[0].values.emplace_back(p.x, p.y);
  EXPECT_TRUE(refine(cage, 2).triangles.empty());
}

TEST(Subdivision, HolesShapeTheSurfaceButAreNotDrawn) {
  Cage cage = skewed(test::cube_cage(SubdivisionScheme::catmull_clark));
  const Mesh whole = refine(cage, 2);
  cage.hole_indices = {3};
  const Mesh pierced = refine(cage, 2);
  EXPECT_EQ(pierced.triangles.size(), whole.triangles.size() * 5 / 6);
  EXPECT_FALSE(pierced.closed);
  EXPECT_EQ(std::count(pierced.triangle_face.begin(), pierced.triangle_face.end(), 3), 0);
  for (const Vec3f& p : pierced.points)
    EXPECT_TRUE(
        std::any_of(whole.points.begin(), whole.points.end(), [&](const Vec3f& q) { return length(p - q) < 1e-6f; }));
}

TEST(Subdivision, ClosedCagesStayWatertight) {
  for (const Cage& cage :
       {test::cube_cage(SubdivisionScheme::catmull_clark), test::pentagon_prism_cage(SubdivisionScheme::catmull_clark),
        test::octahedron_cage(SubdivisionScheme::catmull_clark), test::octahedron_cage(SubdivisionScheme::loop),
        test::pentagon_prism_cage(SubdivisionScheme::bilinear)})
    for (int level = 1; level <= 4; ++level) {
      const Mesh mesh = refine(skewed(cage), level);
      EXPECT_TRUE(mesh.closed);
      // By index alone, each edge once in each direction: consistently wound, too.
      std::vector<std::pair<uint32_t, uint32_t>> edges;
      for (const auto& t : mesh.triangles)
        for (size_t i = 0; i < 3; ++i) edges.emplace_back(t[i], t[(i + 1) % 3]);
      std::sort(edges.begin(), edges.end());
      EXPECT_EQ(std::adjacent_find(edges.begin(), edges.end()), edges.end());
      for (const auto& [a, b] : edges)
        EXPECT_TRUE(std::binary_search(edges.begin(), edges.end(), std::make_pair(b, a)));
      // No point twice.
      const std::vector<int> weld = weld_by_position(mesh.points);
      for (size_t i = 0; i < weld.size(); ++i) EXPECT_EQ(weld[i], static_cast<int>(i));
    }
}

TEST(Subdivision, LeftHandedCagesAreTurnedOver) {
  for (int level : {0, 2}) {
    const Cage right = test::cube_cage(SubdivisionScheme::catmull_clark);
    Cage left = right;
    left.left_handed = true;
    for (size_t f = 0; f < 6; ++f)
      std::reverse(left.face_vertex_indices.begin() + static_cast<long>(4 * f),
                   left.face_vertex_indices.begin() + static_cast<long>(4 * f + 4));
    for (Cage* cage : {&left}) {
      cage->uvs.resize(1);
      cage->uvs[0].interpolation = Interpolation::face_varying;
      for (int i : cage->face_vertex_indices) {
        const Vec3f& p = cage->points[static_cast<size_t>(i)];
        cage->uvs[0].values.emplace_back(p.x + 2 * p.z, p.y);
      }
      cage->face_varying_rule = FaceVaryingRule::all;
    }
    const Mesh mesh = refine(left, level);
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
      const auto& c = mesh.triangles[t];
      const Vec3f &p0 = mesh.points[c[0]], &p1 = mesh.points[c[1]], &p2 = mesh.points[c[2]];
      EXPECT_GT(dot(cross(p1 - p0, p2 - p0), p0 + p1 + p2), 0);
      for (uint32_t i : c) EXPECT_GT(dot(mesh.normals[i], mesh.points[i]), 0);
      if (level > 0) continue;
      const auto& uv = mesh.uv_sets[0].triangles[t];
      for (size_t i = 0; i < 3; ++i) {
        const Vec3f& p = mesh.points[c[i]];
        EXPECT_EQ(mesh.uv_sets[0].values[uv[i]], Vec2f(p.x + 2 * p.z, p.y));
      }
    }
  }
}

// Two halves of a 2 x 1 grid as uv islands (a seam along x = 1), and the same without a seam.
Cage seam_cage(bool seam) {
  Cage cage = test::grid_cage(2, SubdivisionScheme::catmull_clark);
  cage.uvs.resize(1);
  cage.uvs[0].interpolation = Interpolation::face_varying;
  for (size_t corner = 0; corner < 16; ++corner) {
    const Vec3f& p = cage.points[static_cast<size_t>(cage.face_vertex_indices[corner])];
    const bool right = (corner / 4) % 2 == 1;
    cage.uvs[0].values.emplace_back(p.x * p.x + (seam && right ? 100.0f : 0.0f), p.y * p.y);
  }
  return cage;
}

TEST(Subdivision, FaceVaryingRuleActsAtSeams) {
  for (bool seam : {false, true})
    for (FaceVaryingRule rule :
         {FaceVaryingRule::all, FaceVaryingRule::none, FaceVaryingRule::boundaries, FaceVaryingRule::corners_only,
          FaceVaryingRule::corners_plus1, FaceVaryingRule::corners_plus2}) {
      Cage cage = seam_cage(seam);
      cage.face_varying_rule = rule;
      const Mesh mesh = refine(cage, 2);
      ASSERT_EQ(mesh.uv_sets[0].triangles.size(), mesh.triangles.size());
      const bool corners_kept = rule != FaceVaryingRule::none;
      // The middle of the grid: smooth unless the rule is linear or the seam sharpens it. u = x^2 there:
      // limit weights 1/6, 4/6, 1/6 of 0, 1, 4.
      const bool linear = rule == FaceVaryingRule::all;
      const float middle_u = linear || seam ? 1.0f : 8.0f / 6;
      for (size_t t = 0; t < mesh.triangles.size(); ++t)
        for (size_t i = 0; i < 3; ++i) {
          const Vec3f& p = mesh.points[mesh.triangles[t][i]];
          Vec2f uv = mesh.uv_sets[0].values[mesh.uv_sets[0].triangles[t][i]];
          const bool right = mesh.triangle_face[t] % 2 == 1;
          if (seam && right) uv.x -= 100;
          if (p == Vec3f(0, 0, 0) && corners_kept) {
            EXPECT_NEAR(uv.x, 0, 1e-5f);
            EXPECT_NEAR(uv.y, 0, 1e-5f);
          }
          if (p == Vec3f(1, 1, 0) && rule != FaceVaryingRule::none) {
            EXPECT_NEAR(uv.x, middle_u, 2e-5f) << static_cast<int>(rule) << seam;
          }
          EXPECT_LT(uv.x, 4.001f);
          EXPECT_GT(uv.x, -0.001f);
        }
    }
}

TEST(Subdivision, VertexUvsFollowTheSurface) {
  Cage cage = skewed(test::cube_cage(SubdivisionScheme::catmull_clark));
  cage.uvs.resize(1);
  for (const Vec3f& p : cage.points) cage.uvs[0].values.emplace_back(p.z, 2 * p.x - p.y);
  const Mesh mesh = refine(cage, 2);
  EXPECT_TRUE(mesh.uv_sets[0].triangles.empty());
  for (size_t i = 0; i < mesh.points.size(); ++i) {
    const Vec3f& p = mesh.points[i];  // an affine function of position is carried along exactly
    EXPECT_NEAR(mesh.uv_sets[0].values[i].x, p.z, 1e-6f);
    EXPECT_NEAR(mesh.uv_sets[0].values[i].y, 2 * p.x - p.y, 2e-6f);
  }
}

TEST(Subdivision, LevelsAreClamped) {
  const Cage cage = test::cube_cage(SubdivisionScheme::catmull_clark);
  test::RecordingSink sink;
  RefinementOptions options;
  options.level = 99;
  EXPECT_EQ(build_mesh(cage, options, sink.sink()).triangles.size(), 6u << 17);
  EXPECT_TRUE(sink.has("mesh.subdivision.level"));
  options.level = -3;
  EXPECT_EQ(build_mesh(cage, options, sink.sink()).triangles.size(), 12u);
}

// promise: pipeline.memory.meshes
TEST(Subdivision, AMeshBeyondTheMemoryLimitIsRefusedBeforeItIsBuilt) {
  const Cage cage = test::cube_cage(SubdivisionScheme::catmull_clark);
  const auto budget = std::make_shared<MemoryBudget>(3 * estimate_mesh_bytes(cage, 3));
  MemoryReservation memory(budget, MemoryUse::meshes);
  RefinementOptions options;
  options.level = 4;
  options.memory = &memory;
  try {
    build_mesh(cage, options, {});
    FAIL() << "a level too much";
  } catch (const MemoryRefused& e) {
    const std::string text = e.what();
    EXPECT_NE(text.find("a mesh of 3072 triangles needs "), std::string::npos) << text;
    EXPECT_NE(text.find("lower refineLevel"), std::string::npos) << "what a user can do: " << text;
  }
  EXPECT_EQ(budget->in_use(), 0u);
  options.level = 3;
  const Mesh mesh = build_mesh(cage, options, {});
  EXPECT_EQ(budget->in_use(MemoryUse::meshes), mesh.memory_bytes()) << "in the end what the mesh keeps";
}

TEST(Subdivision, EstimateIsAnUpperBound) {
  for (Cage cage :
       {test::cube_cage(SubdivisionScheme::catmull_clark), test::pentagon_prism_cage(SubdivisionScheme::bilinear),
        test::octahedron_cage(SubdivisionScheme::loop), seam_cage(true)})
    for (int level = 0; level <= 4; ++level) {
      const size_t real = refine(cage, level).memory_bytes(), estimate = estimate_mesh_bytes(cage, level);
      EXPECT_GE(estimate, real);
      EXPECT_LE(estimate, 5 * real);
    }
}

TEST(Subdivision, AnyNumberOfThreadsGivesTheSameBytes) {
  Cage cage = skewed(test::grid_cage(24, SubdivisionScheme::catmull_clark));
  cage.crease_indices = {30, 31, 31, 32, 32, 57};
  cage.crease_lengths = {2, 2, 2};
  cage.crease_sharpnesses = {1.5f, 10, 3};
  cage.uvs = seam_cage(false).uvs;
  cage.uvs[0].values.assign(24 * 24 * 4, Vec2f(0.25f, 0.5f));
  std::vector<Mesh> meshes;
  for (size_t threads : {1u, 2u, 4u}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    meshes.push_back(refine(cage, 3));
  }
  for (const Mesh& mesh : meshes) {
    EXPECT_TRUE(same_bytes(mesh.points, meshes[0].points));
    EXPECT_TRUE(same_bytes(mesh.normals, meshes[0].normals));
    EXPECT_TRUE(same_bytes(mesh.uv_sets[0].values, meshes[0].uv_sets[0].values));
    EXPECT_TRUE(same_bytes(mesh.triangles, meshes[0].triangles));
    EXPECT_TRUE(same_bytes(mesh.normal_triangles, meshes[0].normal_triangles));
  }
}

}  // namespace
}  // namespace alabaster
