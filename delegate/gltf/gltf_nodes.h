// The node hierarchy (glTF 2.0, section 3.5): the nodes that a scene draws, and where they stand. Row vectors:
// p' = p * M.
#pragma once

#include "delegate/gltf/gltf_document.h"

namespace alabaster::hd::gltf {

struct PlacedNode {
  size_t index = 0;
  Matrix4d world;
  bool visible = true;          // KHR_node_visibility, of the node and all above it
  std::optional<size_t> above;  // its parent's place in the list of placed nodes; none: it is a root
  bool moves = false;           // the animation moves the node or one above it
};

/// Scale, then rotation, then translation. The rotation is a quaternion (x, y, z, w), which is normalized; one of
/// length zero does not rotate.
Matrix4d trs_matrix(const Vec3d& translation, const double rotation[4], const Vec3d& scale);

/// Nodes with their world transforms, depth first, in the order of the document, each once: a parent precedes its
/// children.
class NodeTree {
 public:
  /// The nodes of `scene`; of the whole document if it is negative. The document must outlive the tree.
  NodeTree(const Document& document, int scene);

  const std::vector<PlacedNode>& nodes() const { return nodes_; }
  /// Computes the world transforms of the nodes that move again, from the model's nodes as they are now.
  void update();

 private:
  Matrix4d world_of(const PlacedNode& node) const;

  const tinygltf::Model& model_;
  std::vector<PlacedNode> nodes_;
};

/// A map onto a plane with a hundred-thousandth of its extent across, so that it can be inverted; others as they are.
Matrix4d with_thickness(const Matrix4d& world);

/// The transforms of a node's instances relative to the node (EXT_mesh_gpu_instancing); one identity without the
/// extension.
std::vector<Matrix4d> instance_transforms(const Document& document, const tinygltf::Node& node);

}  // namespace alabaster::hd::gltf
