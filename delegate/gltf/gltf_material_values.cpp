#include "delegate/gltf/gltf_material_values.h"

#include <algorithm>

namespace alabaster::hd::gltf {
namespace {

template <class Info>
TextureUse use_of_info(const Info& info) {
  TextureUse use{info.index, info.texCoord};
  const auto transform = info.extensions.find("KHR_texture_transform");
  if (transform == info.extensions.end()) return use;
  use.transform = &transform->second;
  if (use.transform->Has("texCoord")) use.coordinates = use.transform->Get("texCoord").GetNumberAsInt();
  return use;
}

}  // namespace

Extension find_extension(const tinygltf::Material& material, const char* name) {
  const auto found = material.extensions.find(name);
  return found == material.extensions.end() ? nullptr : &found->second;
}

double number_or(Extension extension, const char* name, double fallback, double low, double high) {
  if (!extension || !extension->Has(name)) return fallback;
  return std::clamp(extension->Get(name).GetNumberAsDouble(), low, high);
}

Vec3f color_or(Extension extension, const char* name, const Vec3f& fallback, float high) {
  if (!extension || !extension->Has(name)) return fallback;
  Vec3f color;
  for (int c = 0; c < 3; ++c) color[c] = std::clamp(float(extension->Get(name).Get(c).GetNumberAsDouble()), 0.0f, high);
  return color;
}

Vec3f to_color(const std::vector<double>& values, const Vec3f& fallback) {
  if (values.size() < 3) return fallback;
  Vec3f color;
  for (int c = 0; c < 3; ++c) color[c] = std::clamp(float(values[size_t(c)]), 0.0f, 1.0f);
  return color;
}

TextureUse use_in(Extension extension, const char* name) {
  if (!extension || !extension->Has(name)) return {};
  const tinygltf::Value& info = extension->Get(name);
  TextureUse use;
  use.index = info.Get("index").GetNumberAsInt();
  if (info.Has("texCoord")) use.coordinates = info.Get("texCoord").GetNumberAsInt();
  if (info.Has("scale")) use.scale = info.Get("scale").GetNumberAsDouble();
  if (info.Has("extensions") && info.Get("extensions").Has("KHR_texture_transform")) {
    use.transform = &info.Get("extensions").Get("KHR_texture_transform");
    if (use.transform->Has("texCoord")) use.coordinates = use.transform->Get("texCoord").GetNumberAsInt();
  }
  return use;
}

TextureUse use_of(const tinygltf::TextureInfo& info) {
  return use_of_info(info);
}

TextureUse use_of(const tinygltf::NormalTextureInfo& info) {
  TextureUse use = use_of_info(info);
  use.scale = info.scale;
  return use;
}

}  // namespace alabaster::hd::gltf
