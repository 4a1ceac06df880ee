#include "delegate/gltf/gltf_morph.h"

#include <algorithm>

namespace alabaster::hd::gltf {

VertexAttribute read_attribute(const Document& document, const tinygltf::Primitive& primitive, const std::string& name,
                               const std::vector<double>& weights) {
  const auto found = primitive.attributes.find(name);
  if (found == primitive.attributes.end()) return {};
  AccessorView accessor = document.accessors[size_t(found->second)];
  if (name.starts_with("COLOR_") || name.starts_with("WEIGHTS_")) accessor.normalized = true;
  VertexAttribute attribute{read_floats(accessor), accessor.components};
  for (size_t t = 0; t < std::min(weights.size(), primitive.targets.size()); ++t) {
    const auto target = primitive.targets[t].find(name);
    if (weights[t] == 0 || target == primitive.targets[t].end()) continue;
    const AccessorView& view = document.accessors[size_t(target->second)];
    const std::vector<float> moves = read_floats(view);
    const size_t components = std::min(view.components, attribute.components);
    for (size_t i = 0; i < view.count; ++i)
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

}  // namespace alabaster::hd::gltf
