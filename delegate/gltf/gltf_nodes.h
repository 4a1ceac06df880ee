// The node hierarchy (glTF 2.0, section 3.5): the nodes that a scene draws, and where they stand. Row vectors:
// p' = p * M.
#pragma once

#include "delegate/gltf/gltf_document.h"

namespace alabaster::hd::gltf {

struct PlacedNode {
  size_t index = 0;
  Matrix4d world;
  bool visible = true;  // KHR_node_visibility, of the node and all above it
};

/// Scale, then rotation, then translation. The rotation is a quaternion (x, y, z, w), which is normalized; one of
/// length zero does not rotate.
Matrix4d trs_matrix(const Vec3d& translation, const double rotation[4], const Vec3d& scale);

/// The nodes of document.scene, depth first, in the order of the document, each once. `root` is applied after the
/// transforms of all nodes.
std::vector<PlacedNode> placed_nodes(const Document& document, const Matrix4d& root);

/// The world transform of every node, by index. Joints need not be nodes of the scene.
std::vector<Matrix4d> world_transforms(const tinygltf::Model& model);

/// The transforms of a node's instances relative to the node (EXT_mesh_gpu_instancing); one identity without the
/// extension.
std::vector<Matrix4d> instance_transforms(const Document& document, const tinygltf::Node& node);

}  // namespace alabaster::hd::gltf
