#include "delegate/gltf/gltf_vertices.h"

#include <algorithm>
#include <cmath>

namespace alabaster::hd::gltf {
namespace {

// An affine map: the images of the axes, and the translation.
struct Affine {
  Vec3d axis[3] = {Vec3d(0), Vec3d(0), Vec3d(0)}, origin = Vec3d(0);

  void add(const Matrix4d& m, double weight) {
    for (int i = 0; i < 3; ++i) axis[i] += Vec3d(m[i][0], m[i][1], m[i][2]) * weight;
    origin += Vec3d(m[3][0], m[3][1], m[3][2]) * weight;
  }
  Vec3d turn(const Vec3d& v) const { return axis[0] * v.x + axis[1] * v.y + axis[2] * v.z; }
  double determinant() const { return axis[0].cross(axis[1]).dot(axis[2]); }
  // By the cofactors, the inverse transpose times the determinant.
  Vec3d turn_normal(const Vec3d& n) const {
    return axis[1].cross(axis[2]) * n.x + axis[2].cross(axis[0]) * n.y + axis[0].cross(axis[1]) * n.z;
  }
};

Vec3f unit(const Vec3d& v) {
  return std::isfinite(v.length2()) ? Vec3f(v.normalized()) : Vec3f(0);
}

struct Influences {
  std::vector<std::vector<float>> joints, weights;  // by set, four per vertex

  Affine of_vertex(size_t vertex, const std::vector<Matrix4d>& matrices) const {
    double sum = 0;
    for (const std::vector<float>& set : weights)
      for (size_t c = 0; c < 4; ++c) sum += double(set[4 * vertex + c]);
    Affine affine;
    if (!(sum > 0)) {
      const auto first = size_t(joints[0][4 * vertex]);
      affine.add(matrices[first < matrices.size() ? first : 0], 1);
      return affine;
    }
    for (size_t set = 0; set < weights.size(); ++set)
      for (size_t c = 0; c < 4; ++c)
        if (const double weight = double(weights[set][4 * vertex + c]); weight != 0)
          affine.add(matrices[size_t(joints[set][4 * vertex + c])], weight / sum);
    return affine;
  }
};

}  // namespace

VertexAttribute VertexReader::read_at_rest(const std::string& name) const {
  const auto found = primitive.attributes.find(name);
  if (found == primitive.attributes.end()) return {};
  AccessorView accessor = document.accessors[size_t(found->second)];
  if (name.starts_with("COLOR_") || name.starts_with("WEIGHTS_")) accessor.normalized = true;
  return {read_floats(accessor, vertices), accessor.components};
}

VertexAttribute VertexReader::read(const std::string& name) const {
  VertexAttribute attribute = read_at_rest(name);
  for (size_t t = 0; t < std::min(weights.size(), primitive.targets.size()); ++t) {
    const auto target = primitive.targets[t].find(name);
    if (weights[t] == 0 || target == primitive.targets[t].end() || attribute.values.empty()) continue;
    const AccessorView& view = document.accessors[size_t(target->second)];
    const std::vector<float> moves = read_floats(view, vertices);
    const size_t components = std::min(view.components, attribute.components);
    for (size_t i = 0; i < moves.size() / view.components; ++i)
      for (size_t c = 0; c < components; ++c) {
        float& value = attribute.values[i * attribute.components + c];
        value = float(double(value) + weights[t] * double(moves[i * view.components + c]));
      }
  }
  return attribute;
}

std::vector<double> morph_weights(const tinygltf::Node& node, const tinygltf::Mesh& mesh) {
  const std::vector<double>& weights = node.weights.empty() ? mesh.weights : node.weights;
  const bool any = std::any_of(weights.begin(), weights.end(), [](double w) { return w != 0; });
  return any ? weights : std::vector<double>();
}

bool follows_skin(const tinygltf::Primitive& primitive) {
  return primitive.attributes.contains("JOINTS_0") && primitive.attributes.contains("WEIGHTS_0");
}

std::vector<Matrix4d> joint_matrices(const Document& document, const tinygltf::Skin& skin,
                                     const std::vector<Matrix4d>& worlds) {
  std::vector<float> inverse_bind;
  if (skin.inverseBindMatrices >= 0) inverse_bind = read_floats(document.accessors[size_t(skin.inverseBindMatrices)]);
  std::vector<Matrix4d> matrices;
  for (size_t j = 0; j < skin.joints.size(); ++j) {
    Matrix4d bind;
    for (size_t i = 0; i < 16 && !inverse_bind.empty(); ++i)
      bind[int(i / 4)][int(i % 4)] = i % 4 == 3 ? (i == 15 ? 1.0 : 0.0) : double(inverse_bind[16 * j + i]);
    matrices.push_back(bind * worlds[size_t(skin.joints[j])]);
  }
  return matrices;
}

void skin_vertices(const VertexReader& reader, const std::vector<Matrix4d>& matrices, SkinnedVertices* vertices) {
  Influences influences;
  for (int set = 0;; ++set) {
    const std::string number = std::to_string(set);
    VertexAttribute joints = reader.read_at_rest("JOINTS_" + number);
    VertexAttribute weights = reader.read_at_rest("WEIGHTS_" + number);
    if (joints.values.empty() || weights.values.empty()) break;
    influences.joints.push_back(std::move(joints.values));
    influences.weights.push_back(std::move(weights.values));
  }
  size_t reflected = 0;
  for (size_t i = 0; i < vertices->points.size(); ++i) {
    const Affine affine = influences.of_vertex(i, matrices);
    const bool reflects = affine.determinant() < 0;
    reflected += reflects;
    vertices->points[i] = Vec3f(affine.turn(Vec3d(vertices->points[i])) + affine.origin);
    if (!vertices->normals.empty())
      vertices->normals[i] = unit(affine.turn_normal(Vec3d(vertices->normals[i])) * (reflects ? -1.0 : 1.0));
    if (!vertices->tangents.empty()) {
      Vec4f& tangent = vertices->tangents[i];
      const Vec3f turned = unit(affine.turn(Vec3d(Vec3f(tangent.x, tangent.y, tangent.z))));
      tangent = {turned.x, turned.y, turned.z, reflects ? -tangent.w : tangent.w};
    }
  }
  vertices->mirrored = reflected > vertices->points.size() / 2;
}

}  // namespace alabaster::hd::gltf
