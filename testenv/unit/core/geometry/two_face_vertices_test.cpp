// Vertices of two faces, at which OpenSubdiv fails.
#include <gtest/gtest.h>

#include <array>
#include <map>
#include <random>
#include <set>
#include <utility>

#include "core/geometry/mesh.h"
#include "testenv/support/cages.h"
#include "testenv/support/same_bytes.h"

namespace alabaster {
namespace {

using testing::same_bytes;

using Faces = std::vector<std::vector<int>>;

constexpr std::array kRules = {FaceVaryingRule::all,           FaceVaryingRule::none,
                               FaceVaryingRule::boundaries,    FaceVaryingRule::corners_only,
                               FaceVaryingRule::corners_plus1, FaceVaryingRule::corners_plus2};

Faces faces_of(const Cage& cage) {
  Faces faces;
  auto corner = cage.face_vertex_indices.begin();
  for (const int count : cage.face_vertex_counts) {
    faces.emplace_back(corner, corner + count);
    corner += count;
  }
  return faces;
}

void set_faces(const Faces& faces, Cage* cage) {
  cage->face_vertex_counts.clear(), cage->face_vertex_indices.clear();
  for (const std::vector<int>& face : faces) {
    cage->face_vertex_counts.push_back(static_cast<int>(face.size()));
    cage->face_vertex_indices.insert(cage->face_vertex_indices.end(), face.begin(), face.end());
  }
}

class RandomCages {
 public:
  explicit RandomCages(unsigned seed) : random_(seed) {}

  Cage next() {
    const auto scheme = SubdivisionScheme::catmull_clark;
    const int kind = below(4);
    Cage cage = kind == 0   ? test::cube_cage(scheme)
                : kind == 1 ? test::grid_cage(3, scheme)
                : kind == 2 ? test::pentagon_prism_cage(scheme)
                            : test::octahedron_cage(scheme);
    Faces faces = faces_of(cage);
    for (int edits = 1 + below(6); edits > 0; --edits)
      below(2) ? split_an_edge(&faces, &cage.points) : merge_two_faces(&faces);
    set_faces(faces, &cage);
    return cage;
  }

  // Indices as hosts have them, some of them replaced by a few that repeat.
  void add_uvs(Cage* cage) {
    UvPrimvar& uv = cage->uvs.emplace_back();
    uv.name = "st";
    uv.interpolation = Interpolation::face_varying;
    uv.indices = cage->face_vertex_indices;
    const int points = static_cast<int>(cage->points.size()), share = below(4);
    for (int& index : uv.indices) {
      if (below(10) == 0) index = points + below(3);  // a seam
      if (below(10) < share) index = below(4);        // collapsed
    }
    for (int i = 0; i < points + 3; ++i) uv.values.emplace_back(number(), number());
  }

 private:
  int below(int n) { return static_cast<int>(random_() % static_cast<unsigned>(n)); }
  float number() { return static_cast<float>(below(1 << 20)) / (1 << 20); }

  void split_an_edge(Faces* faces, std::vector<Vec3f>* points) {
    const std::vector<int>& face = (*faces)[static_cast<size_t>(below(static_cast<int>(faces->size())))];
    const auto i = static_cast<size_t>(below(static_cast<int>(face.size())));
    const int a = face[i], b = face[(i + 1) % face.size()], middle = static_cast<int>(points->size());
    points->push_back({number(), number(), number()});
    for (std::vector<int>& other : *faces)
      for (size_t k = 0; k < other.size(); ++k) {
        const int from = other[k], to = other[(k + 1) % other.size()];
        if ((from != a || to != b) && (from != b || to != a)) continue;
        other.insert(other.begin() + static_cast<long>(k) + 1, middle);
        break;
      }
  }

  // Across an edge, unless a point would occur twice.
  void merge_two_faces(Faces* faces) {
    const auto f = static_cast<size_t>(below(static_cast<int>(faces->size())));
    std::vector<int> merged = (*faces)[f];
    std::rotate(merged.begin(), merged.begin() + below(static_cast<int>(merged.size())), merged.end());
    for (size_t g = 0; g < faces->size(); ++g) {
      std::vector<int> other = (*faces)[g];
      const auto begin = std::find(other.begin(), other.end(), merged[0]);
      if (g == f || begin == other.end()) continue;
      std::rotate(other.begin(), begin, other.end());
      if (other[1] != merged.back()) continue;
      merged.insert(merged.end(), other.begin() + 2, other.end());
      if (std::set<int>(merged.begin(), merged.end()).size() != merged.size() || faces->size() == 1) return;
      (*faces)[f] = merged;
      faces->erase(faces->begin() + static_cast<long>(g));
      return;
    }
  }

  std::mt19937 random_;
};

// The same values, but no two points have an index in common.
Cage with_own_indices(Cage cage) {
  UvPrimvar& uv = cage.uvs[0];
  std::map<std::pair<int, int>, int> own;
  std::vector<Vec2f> values;
  for (size_t corner = 0; corner < uv.indices.size(); ++corner) {
    const auto [place, added] =
        own.emplace(std::pair(cage.face_vertex_indices[corner], uv.indices[corner]), static_cast<int>(values.size()));
    if (added) values.push_back(uv.values[static_cast<size_t>(uv.indices[corner])]);
    uv.indices[corner] = place->second;
  }
  uv.values = values;
  return cage;
}

Mesh refine(const Cage& cage, const DiagnosticSink& sink = {}) {
  RefinementOptions options;
  options.level = 1;
  return build_mesh(cage, options, sink);
}

TEST(TwoFaceVertices, CollapsedValuesOfRandomCagesAreThoseOfEachPoint) {
  RandomCages cages(2);
  for (int i = 0; i < 300; ++i) {
    Cage cage = cages.next();
    cages.add_uvs(&cage);
    cage.face_varying_rule = kRules[static_cast<size_t>(i) % kRules.size()];
    if (i % 2) cage.boundary_rule = BoundaryRule::edge_only;
    const Mesh mesh = refine(cage);
    EXPECT_TRUE(same_bytes(mesh.uv_sets[0].values, refine(with_own_indices(cage)).uv_sets[0].values)) << i;
    for (const Vec2f& uv : mesh.uv_sets[0].values) {  // a mean of values from 0 to 1
      EXPECT_GT(std::min(uv.x, uv.y), -0.01f) << i;
      EXPECT_LT(std::max(uv.x, uv.y), 1.01f) << i;
    }
  }
}

// Without seams, the values are carried as the points are.
TEST(TwoFaceVertices, ValuesOfPointsFollowTheSurface) {
  RandomCages cages(3);
  for (int i = 0; i < 100; ++i) {
    Cage cage = cages.next();
    cage.face_varying_rule = FaceVaryingRule::corners_only;  // as the surface's own
    UvPrimvar& uv = cage.uvs.emplace_back();
    uv.interpolation = Interpolation::face_varying;
    uv.indices = cage.face_vertex_indices;
    for (const Vec3f& p : cage.points) uv.values.emplace_back(p.x, p.y);
    const Mesh mesh = refine(cage);
    const MeshAttribute<Vec2f>& refined = mesh.uv_sets[0];
    for (size_t t = 0; t < mesh.triangles.size(); ++t)
      for (size_t k = 0; k < 3; ++k) {
        const Vec3f& p = mesh.points[mesh.triangles[t][k]];
        const Vec2f& value = refined.values[refined.triangles[t][k]];
        ASSERT_NEAR(value.x, p.x, 2e-6f) << i;
        ASSERT_NEAR(value.y, p.y, 2e-6f) << i;
      }
  }
}

// A grid whose middle edge has a point more, and creases at its ends and elsewhere.
TEST(TwoFaceVertices, CreasesAtThemAreLeftOutWithAWarning) {
  Cage cage = test::grid_cage(4, SubdivisionScheme::catmull_clark);
  Faces faces = faces_of(cage);
  const int middle = static_cast<int>(cage.points.size());
  cage.points.emplace_back(0.5f, 1, 0.5f);
  for (std::vector<int>& face : faces)
    for (size_t k = 0; k < face.size(); ++k) {
      const int from = face[k], to = face[(k + 1) % face.size()];
      if (std::minmax(from, to) != std::minmax(5, 6)) continue;
      face.insert(face.begin() + static_cast<long>(k) + 1, middle);
      break;
    }
  set_faces(faces, &cage);
  cage.crease_indices = {5, 10, 6, middle, 17, 18};
  cage.crease_lengths = {2, 2, 2};
  cage.crease_sharpnesses = {3, 10, 3};
  test::RecordingSink sink;
  const Mesh mesh = refine(cage, sink.sink());
  ASSERT_EQ(sink.all().size(), 1u);
  EXPECT_EQ(sink.all()[0].severity, Severity::warning);
  EXPECT_NE(sink.all()[0].text.find("2 edges lose their crease, the first from point 5 to 10"), std::string::npos)
      << sink.all()[0].text;
  cage.crease_indices = {17, 18}, cage.crease_lengths = {2}, cage.crease_sharpnesses = {3};
  EXPECT_TRUE(same_bytes(mesh.points, refine(cage).points));
}

// Two triangles back to back, on an edge that has other faces, too.
TEST(TwoFaceVertices, AtAnEdgeOfManyFacesTheCageIsDrawnUnrefined) {
  Cage cage = test::octahedron_cage(SubdivisionScheme::catmull_clark);
  Faces faces = faces_of(cage);
  cage.points.emplace_back(2.0f, 2.0f, 2.0f);
  faces.push_back({0, 2, 6}), faces.push_back({0, 6, 2});
  set_faces(faces, &cage);
  test::RecordingSink sink;
  EXPECT_EQ(refine(cage, sink.sink()).triangles.size(), 10u);
  ASSERT_TRUE(sink.has("mesh.subdivision.topology"));
  EXPECT_NE(sink.all()[0].text.find("drawn unrefined"), std::string::npos) << sink.all()[0].text;
}

}  // namespace
}  // namespace alabaster
