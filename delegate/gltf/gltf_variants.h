// KHR_materials_variants: which material a primitive uses.
#pragma once

#include "delegate/gltf/gltf_document.h"

namespace alabaster::hd::gltf {

/// Gives every primitive that has a material for the document's variant that material.
void apply_variant(size_t variant, tinygltf::Model* model);

}  // namespace alabaster::hd::gltf
