// Vertex attributes as floats, with morph targets added (glTF 2.0, section 3.7.2.2).
#pragma once

#include "delegate/gltf/gltf_document.h"

namespace alabaster::hd::gltf {

struct VertexAttribute {
  std::vector<float> values;  // components interleaved; empty: the primitive lacks the attribute
  size_t components = 0;
};

/// `weights` are those of the primitive's targets; those that it lacks are zero. A target adds to as many components as
/// it has: that of TANGENT leaves the sign as it is. Integers of COLOR_n and WEIGHTS_n are normalized, as glTF
/// requires.
VertexAttribute read_attribute(const Document& document, const tinygltf::Primitive& primitive, const std::string& name,
                               const std::vector<double>& weights);

/// The weights of a node's morph targets: the node's own, else the mesh's. Empty if all are zero.
std::vector<double> morph_weights(const tinygltf::Node& node, const tinygltf::Mesh& mesh);

}  // namespace alabaster::hd::gltf
