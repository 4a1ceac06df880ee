#include "delegate/gltf/gltf_variants.h"

namespace alabaster::hd::gltf {
namespace {

// The primitive's own material if it has none for the variant.
int material_for(const tinygltf::Primitive& primitive, size_t variant) {
  const auto extension = primitive.extensions.find("KHR_materials_variants");
  if (extension == primitive.extensions.end()) return primitive.material;
  const tinygltf::Value& mappings = extension->second.Get("mappings");
  for (size_t m = 0; m < mappings.ArrayLen(); ++m) {
    const tinygltf::Value &mapping = mappings.Get(int(m)), &variants = mapping.Get("variants");
    for (size_t v = 0; v < variants.ArrayLen(); ++v)
      if (size_t(variants.Get(int(v)).GetNumberAsInt()) == variant) return mapping.Get("material").GetNumberAsInt();
  }
  return primitive.material;
}

}  // namespace

void apply_variant(size_t variant, tinygltf::Model* model) {
  for (tinygltf::Mesh& mesh : model->meshes)
    for (tinygltf::Primitive& primitive : mesh.primitives) primitive.material = material_for(primitive, variant);
}

}  // namespace alabaster::hd::gltf
