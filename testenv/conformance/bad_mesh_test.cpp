// Contract 1.4: meshes that a host may send, and the crashes of section 3 ("Crashes on bad data"). Beside each bad mesh
// stands a good one: its pixels must not change, the render must converge, and mending the mesh must show it.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "testenv/conformance/scenes.h"

namespace conformance {
namespace {

const float kNan = std::numeric_limits<float>::quiet_NaN(), kInfinity = std::numeric_limits<float>::infinity();

struct Fault {
  std::string name;
  std::function<void(Mesh&)> spoil;  // of a rectangle of 2 x 2 faces, 9 points
};
void PrintTo(const Fault& fault, std::ostream* out) {
  *out << fault.name;
}

// Edits the mesh's points as a vector.
void edit_points(Mesh& mesh, const std::function<void(std::vector<Vec3f>&)>& edit) {
  const auto* old = mesh.primvars["points"].value.get<Array<Vec3f>>();
  std::vector<Vec3f> points(old->begin(), old->end());
  edit(points);
  mesh.primvars["points"].value = Array<Vec3f>(points);
}

void set_point(Mesh& mesh, size_t index, const Vec3f& point) {
  edit_points(mesh, [&](auto& points) { points[index] = point; });
}

void set_points(Mesh& mesh, size_t count) {
  edit_points(mesh, [&](auto& points) { points.resize(count); });
}

void subdivide(Mesh& mesh) {
  mesh.topology.scheme = "catmullClark";
  mesh.style.refineLevel = 2;
}

std::vector<Fault> topology_faults() {
  return {
      {"EmptyArrays", [](Mesh& m) { m = Mesh(); }},  // arnold#1502, #1530, #687, rpr#636
      {"NoPoints", [](Mesh& m) { m.primvars.erase("points"); }},
      {"EmptyPoints", [](Mesh& m) { m.primvars["points"].value = Array<Vec3f>(); }},
      {"PointsOfAnotherType",
       [](Mesh& m) {
         m.primvars["points"].value = Array<float>{1, 2, 3};
       }},
      {"PointsFewerThanTheHighestIndex", [](Mesh& m) { set_points(m, 5); }},
      {"FaceOfTwoVertices",
       [](Mesh& m) {
         m.topology.faceVertexCounts = {2, 4, 4, 4, 2};
       }},
      {"FaceOfNoVertex",
       [](Mesh& m) {
         m.topology.faceVertexCounts = {0, 4, 4, 4, 4};
       }},
      {"NegativeCount",
       [](Mesh& m) {
         m.topology.faceVertexCounts = {-4, 4, 4, 4};
       }},
      {"NegativeIndex",
       [](Mesh& m) { m.topology.faceVertexIndices = {0, 1, 4, -3, 1, 2, 5, 4, 3, 4, 7, 6, 4, 5, 8, 7}; }},
      {"IndexOutOfRange",
       [](Mesh& m) { m.topology.faceVertexIndices = {0, 1, 4, 2147483647, 1, 2, 5, 4, 3, 4, 7, 6, 4, 5, 8, 7}; }},
      {"FewerIndicesThanCounts", [](Mesh& m) { m.topology.faceVertexIndices = {0, 1, 4, 3, 1, 2}; }},
      {"MoreIndicesThanCounts",
       [](Mesh& m) {
         m.topology.faceVertexCounts = {4, 4};
       }},
      {"CountsWithoutIndices", [](Mesh& m) { m.topology.faceVertexIndices = {}; }},
      {"IndicesWithoutCounts", [](Mesh& m) { m.topology.faceVertexCounts = {}; }},
      {"HugeCount",
       [](Mesh& m) {
         m.topology.faceVertexCounts = {2147483647, 2147483647, 4, 4};
       }},
      {"HoleOutOfRange",
       [](Mesh& m) {
         m.topology.holeIndices = {-1, 1000000};
       }},
      {"AllFacesAreHoles",
       [](Mesh& m) {
         m.topology.holeIndices = {0, 1, 2, 3};
       }},
      {"FaceOfOneVertexFourTimes",
       [](Mesh& m) { m.topology.faceVertexIndices = {0, 0, 0, 0, 1, 2, 5, 4, 3, 4, 7, 6, 4, 5, 8, 7}; }},
      {"UnknownScheme", [](Mesh& m) { m.topology.scheme = "no such scheme"; }},
      {"UnknownOrientation", [](Mesh& m) { m.topology.orientation = "no such orientation"; }},
      {"NotANumber", [](Mesh& m) { set_point(m, 4, Vec3f(kNan, 0, 0)); }},
      {"HugePoint", [](Mesh& m) { set_point(m, 8, Vec3f(1e30f, 1e30f, 0)); }},
      {"InfinitePoint", [](Mesh& m) { set_point(m, 0, Vec3f(0, -kInfinity, 0)); }},
      {"AllPointsEqual", [](Mesh& m) { m.primvars["points"].value = Array<Vec3f>(std::vector<Vec3f>(9, Vec3f(0))); }},
      {"SingularTransform", [](Mesh& m) { m.transform.setScale(Vec3d(0, 0, 0)); }},
      {"TransformBeyondFloat", [](Mesh& m) { m.transform.setScale(Vec3d(1e300, 1e300, 1e300)); }},
      {"TransformNotANumber", [](Mesh& m) { m.transform[3][0] = double(kNan); }},
      {"RefineLevelOutOfRange",
       [](Mesh& m) {
         subdivide(m);
         m.style.refineLevel = -3;
       }},
      {"MaterialThatDoesNotExist", [](Mesh& m) { m.material = "/no such material"; }},
      {"InstancerThatDoesNotExist", [](Mesh& m) { m.instancer = "/no such instancer"; }},
  };
}

std::vector<Fault> tag_faults() {
  const auto crease = [](Array<int32_t> indices, Array<int32_t> lengths, Array<float> weights) {
    return [=](Mesh& m) {
      subdivide(m);
      m.tags.creaseIndices = indices, m.tags.creaseLengths = lengths, m.tags.creaseWeights = weights;
    };
  };
  const auto corner = [](Array<int32_t> indices, Array<float> weights) {
    return [=](Mesh& m) {
      subdivide(m);
      m.tags.cornerIndices = indices, m.tags.cornerWeights = weights;
    };
  };
  return {
      {"UnknownTags",
       [](Mesh& m) {
         subdivide(m);
         m.tags.interpolateBoundary = m.tags.creaseMethod = "no such tag";
         m.tags.faceVaryingLinearInterpolation = m.tags.triangleSubdivision = "no such tag";
       }},
      {"CreaseOfOneVertex", crease({4}, {1}, {1})},
      {"CreaseOfNegativeLength", crease({0, 1}, {-2}, {1})},
      {"CreaseLongerThanItsIndices", crease({0, 1}, {5}, {1})},
      {"CreaseWithoutWeights", crease({0, 1}, {2}, {})},
      {"CreaseOfTooManyWeights", crease({0, 1, 2}, {3}, {1, 2, 3, 4})},
      {"CreaseThatIsNoEdge", crease({0, 8}, {2}, {2})},
      {"CreaseOutOfRange", crease({0, 99}, {2}, {2})},
      {"CreaseOfNegativeIndex", crease({-1, 0}, {2}, {2})},
      {"CreaseOfNegativeWeight", crease({0, 1}, {2}, {-1})},
      {"CreaseWeightNotANumber", crease({0, 1}, {2}, {kNan})},
      {"CornerOutOfRange", corner({-1, 99}, {1, 1})},
      {"CornersWithoutWeights", corner({0, 1}, {})},
      {"CornerOfNegativeWeight", corner({4}, {-1})},
  };
}

std::vector<Fault> cage_faults() {
  return {
      {"FewerPointsThanACageNeeds",
       [](Mesh& m) {
         subdivide(m);
         set_points(m, 5);
       }},
      {"LoopOfQuadrangles",
       [](Mesh& m) {
         subdivide(m);
         m.topology.scheme = "loop";
       }},
      // bb#189: an edge of three faces, a vertex of two fans, a face that has a vertex twice
      {"NotManifold",
       [](Mesh& m) {
         subdivide(m);
         m.topology.faceVertexIndices = {0, 1, 4, 3, 1, 2, 5, 4, 1, 4, 7, 6, 4, 5, 4, 8};
       }},
      {"ReversedNeighbours",
       [](Mesh& m) {
         subdivide(m);
         m.topology.faceVertexIndices = {0, 3, 4, 1, 1, 2, 5, 4, 3, 4, 7, 6, 4, 7, 8, 5};
       }},
      {"CageNotANumber",
       [](Mesh& m) {
         subdivide(m);
         set_point(m, 4, Vec3f(kNan));
       }},
  };
}

std::vector<Fault> primvar_faults() {
  const auto uv = [](Value value, Interpolation interpolation, Array<int32_t> indices = {}) {
    return [=](Mesh& m) { m.primvars["st"] = {value, interpolation, "textureCoordinate", indices}; };
  };
  const auto normals = [](Value value, Interpolation interpolation, Array<int32_t> indices = {}) {
    return [=](Mesh& m) { m.primvars["normals"] = {value, interpolation, "normal", indices}; };
  };
  const Array<Vec2f> three = {{0, 0}, {1, 0}, {1, 1}};
  return {
      {"TooFewTextureCoordinates", uv(three, Interpolation::vertex)},  // arnold#1932
      {"NoTextureCoordinates", uv(Array<Vec2f>(), Interpolation::vertex)},
      {"FaceVaryingWithoutIndices", uv(three, Interpolation::faceVarying)},  // arnold#853, #592
      {"IndicesOutOfRange", uv(three, Interpolation::faceVarying, Array<int32_t>(std::vector<int32_t>(16, 7)))},
      {"NegativeIndices", uv(three, Interpolation::faceVarying, Array<int32_t>(std::vector<int32_t>(16, -1)))},
      {"TooFewIndices", uv(three, Interpolation::vertex, {0, 1})},
      {"TextureCoordinatesOfAnotherType", uv(Array<std::string>{"a", "b"}, Interpolation::vertex)},
      {"ANumberForAnArray", uv(3.0f, Interpolation::vertex)},
      {"CoordinatesNotANumber", uv(Array<Vec2f>(std::vector<Vec2f>(9, Vec2f(kNan))), Interpolation::vertex)},
      {"ConstantTextureCoordinates", uv(Array<Vec2f>{{0, 0}}, Interpolation::constant)},
      {"NormalsOfAnotherType", normals(Array<int32_t>{1, 2}, Interpolation::vertex)},
      {"TooFewNormals", normals(Array<Vec3f>{{0, 0, 1}}, Interpolation::vertex)},
      {"NormalsOfLengthZero", normals(Array<Vec3f>(std::vector<Vec3f>(9, Vec3f(0))), Interpolation::vertex)},
      {"NormalsNotANumber", normals(Array<Vec3f>(std::vector<Vec3f>(9, Vec3f(kNan))), Interpolation::vertex)},
      {"NormalsForCorners", normals(Array<Vec3f>(std::vector<Vec3f>(15, Vec3f(0))), Interpolation::faceVarying)},
      {"UniformColorsOfTheWrongNumber",
       [](Mesh& m) {
         m.primvars["displayColor"] = {Array<Vec3f>{kRed}, Interpolation::uniform, "color", {}};
       }},
      {"UnknownPrimvars",
       [](Mesh& m) {
         m.primvars["no such"] = {Array<Matrix4d>{{}}, Interpolation::faceVarying, "none", {}};
       }},
      {"MotionOfAnotherSize",  // arnold#2231
       [](Mesh& m) {
         m.moving_points = {{0, 1}, {Array<Vec3f>{{0, 0, 0}}, Array<Vec3f>{{1, 1, 1}, {2, 2, 2}}}};
       }},
  };
}

class BadMesh : public testing::TestWithParam<Fault> {};

TEST_P(BadMesh, HarmsNoOtherAndMayBeMended) {
  Host host;
  host.material("/red") = glow(kRed);
  host.material("/green") = glow(kGreen);
  host.mesh("/good") = rectangle(-1, -1, 0, 1);
  host.mesh("/good").material = "/red";
  Mesh whole = rectangle(0.25, -1, 1, 1, 2);
  whole.material = "/green";
  host.mesh("/bad") = whole;
  GetParam().spoil(host.mesh("/bad"));
  const Picture spoilt = host.render();
  EXPECT_EQ(host.pass->GetState(), PassState::converged) << host.text_stat("error");
  for (double y : {-0.9, 0.0, 0.9}) EXPECT_TRUE(near(spoilt.color(-0.5, y), kRed)) << y;

  host.mesh("/bad") = whole;
  const Picture mended = host.render();
  EXPECT_TRUE(near(mended.color(-0.5, 0), kRed));
  for (double y : {-0.9, 0.1, 0.9}) EXPECT_TRUE(near(mended.color(0.6, y), kGreen)) << y;
}

const auto name_of = [](const auto& info) { return info.param.name; };
INSTANTIATE_TEST_SUITE_P(Topology, BadMesh, testing::ValuesIn(topology_faults()), name_of);
INSTANTIATE_TEST_SUITE_P(Tags, BadMesh, testing::ValuesIn(tag_faults()), name_of);
INSTANTIATE_TEST_SUITE_P(Cages, BadMesh, testing::ValuesIn(cage_faults()), name_of);
INSTANTIATE_TEST_SUITE_P(Primvars, BadMesh, testing::ValuesIn(primvar_faults()), name_of);

}  // namespace
}  // namespace conformance
