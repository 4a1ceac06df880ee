// Skins (glTF 2.0, section 3.7.3): vertices that follow the joints of a skeleton.
#pragma once

#include "delegate/gltf/gltf_document.h"

namespace alabaster::hd::gltf {

/// The matrix of each joint of a skin: from the mesh's own space to that of `worlds`, the world transform of every
/// node. The transform of the node that has the skin takes no part.
std::vector<Matrix4d> joint_matrices(const Document& document, const tinygltf::Skin& skin,
                                     const std::vector<Matrix4d>& worlds);

struct SkinnedVertices {
  std::vector<Vec3f> points, normals;  // no normals: none
  std::vector<Vec4f> tangents;
  bool mirrored = false;  // most vertices are reflected, so that the winding of the faces is the other one
};

/// Moves the vertices by the mean of their joints' matrices, weighted by all sets JOINTS_n and WEIGHTS_n. Weights count
/// relative to their sum; a vertex without any follows its first joint.
void skin_vertices(const Document& document, const tinygltf::Primitive& primitive,
                   const std::vector<Matrix4d>& joint_matrices, SkinnedVertices* vertices);

}  // namespace alabaster::hd::gltf
