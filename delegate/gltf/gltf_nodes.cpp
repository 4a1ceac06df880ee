#include "delegate/gltf/gltf_nodes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace alabaster::hd::gltf {
namespace {

// Row vectors: read row by row, glTF's column-major matrix for column vectors is already transposed.
Matrix4d local_transform(const tinygltf::Node& node) {
  if (node.matrix.size() == 16) {
    Matrix4d m;
    for (size_t i = 0; i < 16; ++i) m[int(i / 4)][int(i % 4)] = i % 4 == 3 ? (i == 15 ? 1.0 : 0.0) : node.matrix[i];
    return m;
  }
  const auto vector = [](const std::vector<double>& v, double fallback) {
    return v.size() == 3 ? Vec3d(v[0], v[1], v[2]) : Vec3d(fallback);
  };
  const double none[4] = {0, 0, 0, 1};
  return trs_matrix(vector(node.translation, 0), node.rotation.size() == 4 ? node.rotation.data() : none,
                    vector(node.scale, 1));
}

bool is_visible(const tinygltf::Node& node) {
  const auto extension = node.extensions.find("KHR_node_visibility");
  if (extension == node.extensions.end() || !extension->second.Has("visible")) return true;
  return extension->second.Get("visible").Get<bool>();
}

// Without a scene, every root of the document.
std::vector<size_t> roots_of(const Document& document, int scene) {
  std::vector<size_t> roots, others;
  if (scene < 0) {
    for (size_t n = 0; n < document.parents.size(); ++n)
      if (document.parents[n] < 0) roots.push_back(n);
    return roots;
  }
  // Child nodes that a scene lists come last: they are used only if their parents are not in the scene.
  for (const int n : document.model.scenes[size_t(scene)].nodes)
    (document.parents[size_t(n)] < 0 ? roots : others).push_back(size_t(n));
  roots.insert(roots.end(), others.begin(), others.end());
  return roots;
}

// By node.
std::vector<char> animated_transforms(const tinygltf::Model& model) {
  std::vector<char> animated(model.nodes.size(), 0);
  for (const tinygltf::Animation& animation : model.animations)
    for (const tinygltf::AnimationChannel& channel : animation.channels)
      if (channel.target_path != "weights") animated[size_t(channel.target_node)] = 1;
  return animated;
}

}  // namespace

Matrix4d trs_matrix(const Vec3d& translation, const double rotation[4], const Vec3d& scale) {
  Matrix4d m, moved;
  m.setScale(scale);
  const Imath::Quatd turn(rotation[3], Vec3d(rotation[0], rotation[1], rotation[2]));
  if (turn.length() > 0) m *= turn.normalized().toMatrix44();
  moved.setTranslation(translation);
  return m * moved;
}

// Not recursive: chains may be long.
NodeTree::NodeTree(const Document& document, int scene) : model_(document.model) {
  const std::vector<char> animated = animated_transforms(model_);
  std::vector<char> visited(model_.nodes.size(), 0);
  std::vector<PlacedNode> open;
  for (const size_t first : roots_of(document, scene)) {
    open.push_back({first, {}, true, {}, false});
    while (!open.empty()) {
      PlacedNode node = open.back();
      open.pop_back();
      if (std::exchange(visited[node.index], 1)) continue;
      const tinygltf::Node& authored = model_.nodes[node.index];
      node.world = world_of(node);
      node.visible = node.visible && is_visible(authored);
      node.moves = node.moves || animated[node.index];
      nodes_.push_back(node);
      for (auto c = authored.children.rbegin(); c != authored.children.rend(); ++c)
        open.push_back({size_t(*c), {}, node.visible, nodes_.size() - 1, node.moves});
    }
  }
}

Matrix4d NodeTree::world_of(const PlacedNode& node) const {
  const Matrix4d local = local_transform(model_.nodes[node.index]);
  return node.above ? local * nodes_[*node.above].world : local;
}

void NodeTree::update() {
  for (PlacedNode& node : nodes_)
    if (node.moves) node.world = world_of(node);
}

Matrix4d with_thickness(const Matrix4d& world) {
  constexpr double kThickness = 1e-5, kFlat = 1e-12, kLine = 1e-9;
  std::array<Vec3d, 3> axes;
  double longest = 0;
  for (int i = 0; i < 3; ++i) {
    axes[size_t(i)] = {world[i][0], world[i][1], world[i][2]};
    longest = std::max(longest, axes[size_t(i)].length());
  }
  Vec3d normal(0), across(0);
  for (size_t i = 0; i < 3; ++i)
    if (const Vec3d n = axes[i].cross(axes[(i + 1) % 3]); n.length2() > normal.length2()) normal = n;
  const double determinant = axes[0].cross(axes[1]).dot(axes[2]);
  const bool is_flat = std::abs(determinant) <= kFlat * longest * longest * longest;
  if (!is_flat || !(normal.length() > kLine * longest * longest)) return world;
  normal.normalize();
  for (size_t i = 0; i < 3; ++i) across[int(i)] = normal.dot(axes[(i + 1) % 3].cross(axes[(i + 2) % 3]));
  across.normalize();  // the direction that the map loses
  Matrix4d thick = world;
  for (int i = 0; i < 3; ++i)
    for (int c = 0; c < 3; ++c) thick[i][c] += kThickness * longest * across[i] * normal[c];
  return thick;
}

std::vector<Matrix4d> instance_transforms(const Document& document, const tinygltf::Node& node) {
  const auto extension = node.extensions.find("EXT_mesh_gpu_instancing");
  if (extension == node.extensions.end() || !extension->second.Has("attributes")) return {Matrix4d()};
  const tinygltf::Value& attributes = extension->second.Get("attributes");
  size_t count = 1;
  const auto read = [&](const char* name) {
    if (!attributes.Has(name)) return std::vector<float>();
    const AccessorView& accessor = document.accessors[size_t(attributes.Get(name).GetNumberAsInt())];
    count = accessor.count;
    return read_floats(accessor);
  };
  const std::vector<float> translations = read("TRANSLATION"), rotations = read("ROTATION"), scales = read("SCALE");
  std::vector<Matrix4d> transforms;
  transforms.reserve(count);
  for (size_t i = 0; i < count; ++i) {
    const auto vector = [i](const std::vector<float>& v, double fallback) {
      return v.empty() ? Vec3d(fallback) : Vec3d(Vec3f(v[3 * i], v[3 * i + 1], v[3 * i + 2]));
    };
    double rotation[4] = {0, 0, 0, 1};
    for (size_t c = 0; c < 4 && !rotations.empty(); ++c) rotation[c] = double(rotations[4 * i + c]);
    transforms.push_back(trs_matrix(vector(translations, 0), rotation, vector(scales, 1)));
  }
  return transforms;
}

}  // namespace alabaster::hd::gltf
