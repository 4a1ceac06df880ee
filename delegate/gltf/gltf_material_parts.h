// The parts of a glTF material, each translated into parameters of AlabasterDisney. delegate/manual/gltf.md has the
// table of translations.
#pragma once

#include "delegate/gltf/gltf_material_builder.h"

namespace alabaster::hd::gltf {

/// A material's base colour and opacity, whichever model has them.
struct BaseColor {
  Vec3f color{1};
  double alpha = 1;
  TextureUse texture;
};

// gltf_material_base.cpp
BaseColor base_color_of(const tinygltf::Material& material);
void set_base(const BaseColor& base, const VertexColors& vertex, MaterialBuilder* material);
void set_unlit(const BaseColor& base, const VertexColors& vertex, MaterialBuilder* material);
void set_opacity(const BaseColor& base, const VertexColors& vertex, MaterialBuilder* material);
void set_emission(MaterialBuilder* material);

// gltf_material_layers.cpp: reflection. After set_base.
void set_dielectric(MaterialBuilder* material);
void set_anisotropy(MaterialBuilder* material);
void set_clearcoat(MaterialBuilder* material);
void set_sheen(MaterialBuilder* material);
void set_iridescence(MaterialBuilder* material);

// gltf_material_interior.cpp: transmission and scattering.
void set_transmission(MaterialBuilder* material);
/// Replaces the base colour by that of a scattering volume.
void set_scatter(MaterialBuilder* material);

}  // namespace alabaster::hd::gltf
