// Values of a glTF material and its extensions. The schema has checked their types; values out of range are clamped.
#pragma once

#include "delegate/api/types.h"
#include "delegate/gltf/tinygltf_model.h"

namespace alabaster::hd::gltf {

using Extension = const tinygltf::Value*;  // null: the material does not have it

/// A texture as a material refers to it.
struct TextureUse {
  int index = -1;                 // in `textures`; -1: none
  int coordinates = 0;            // TEXCOORD_n
  double scale = 1;               // of a normal texture
  Extension transform = nullptr;  // KHR_texture_transform
};

Extension find_extension(const tinygltf::Material& material, const char* name);
double number_or(Extension extension, const char* name, double fallback, double low = 0, double high = 1);
Vec3f color_or(Extension extension, const char* name, const Vec3f& fallback, float high = 1);
/// The first three of `values`, clamped to 0..1; `fallback` if there are fewer.
Vec3f to_color(const std::vector<double>& values, const Vec3f& fallback);

/// The texture that an extension has under `name`, KHR_texture_transform's texCoord applied.
TextureUse use_in(Extension extension, const char* name);
TextureUse use_of(const tinygltf::TextureInfo& info);
TextureUse use_of(const tinygltf::NormalTextureInfo& info);

}  // namespace alabaster::hd::gltf
