// The vertices of a primitive: attributes as floats, with morph targets added (glTF 2.0, section 3.7.2.2), and skins,
// whose joints vertices follow (section 3.7.3).
#pragma once

#include "delegate/gltf/gltf_document.h"

namespace alabaster::hd::gltf {

struct VertexAttribute {
  std::vector<float> values;  // components interleaved; empty: the primitive lacks the attribute
  size_t components = 0;
};

struct VertexReader {
  const Document& document;
  const tinygltf::Primitive& primitive;
  std::vector<uint32_t> vertices;      // that are read, rising; empty: all
  const std::vector<double>& weights;  // of the primitive's morph targets; those missing are zero

  /// A morph target is added to the components that it has; a target of TANGENT has three, and the sign is kept.
  /// Integers of COLOR_n and WEIGHTS_n are normalized (glTF 2.0, section 3.7.2.1).
  VertexAttribute read(const std::string& name) const;
  /// Without morph targets.
  VertexAttribute read_at_rest(const std::string& name) const;
};

/// The weights of a node's morph targets: the node's own, else the mesh's. Empty if all are zero.
std::vector<double> morph_weights(const tinygltf::Node& node, const tinygltf::Mesh& mesh);

/// The matrix of each joint of a skin: from the mesh's own space to that of `worlds`, the world transform of every
/// node. The transform of the node that has the skin takes no part.
std::vector<Matrix4d> joint_matrices(const Document& document, const tinygltf::Skin& skin,
                                     const std::vector<Matrix4d>& worlds);

/// True if a skin places the primitive: it has influences of joints.
bool follows_skin(const tinygltf::Primitive& primitive);

struct SkinnedVertices {
  std::vector<Vec3f> points, normals;  // no normals: none
  std::vector<Vec4f> tangents;
  bool mirrored = false;  // most vertices are reflected, so that the winding of the faces is the other one
};

/// Moves the vertices by the mean of their joints' matrices, weighted by all sets JOINTS_n and WEIGHTS_n. Weights count
/// relative to their sum; a vertex without any follows its first joint.
void skin_vertices(const VertexReader& reader, const std::vector<Matrix4d>& joint_matrices, SkinnedVertices* vertices);

}  // namespace alabaster::hd::gltf
