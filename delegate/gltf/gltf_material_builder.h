// Collects the network of one material: a node AlabasterDisney, and the textures and primvars that are connected to it.
#pragma once

#include <string>
#include <vector>

#include "delegate/api/scene_types.h"
#include "delegate/gltf/gltf_document.h"
#include "delegate/gltf/gltf_material_values.h"

namespace alabaster::hd::gltf {

/// The primvar that holds TEXCOORD_n: "st", "st1", "st2" and so on.
inline std::string uv_set_name(int n) {
  return n == 0 ? "st" : "st" + std::to_string(n);
}

/// The vertex colours of the primitives that have a material.
struct VertexColors {
  bool colors = false, alphas = false;
};
/// For each material of the document.
std::vector<VertexColors> find_vertex_colors(const Document& document);

/// The value that an input takes from a texture: `output` of texel * scale + bias. Colours are stored as sRGB, numbers
/// as they are; an alpha channel is a number in both.
struct Reading {
  const char* output = "rgb";
  const char* color_space = "raw";
  Vec4f scale{1}, bias{0};
};
inline Reading color_reading() {
  return {"rgb", "sRGB"};
}
inline Reading number_reading(const char* channel) {
  return {channel};
}
/// The alpha channel of a texture whose colours are used as well.
inline Reading alpha_reading() {
  return {"a", "sRGB"};
}
/// A tangent-space normal, its x and y scaled.
Reading normal_reading(double scale);

class MaterialBuilder {
 public:
  /// `element` is the material's place in the document, for messages.
  MaterialBuilder(const Document& document, const tinygltf::Material& material, const Path& id, std::string element,
                  Report& report);

  const tinygltf::Material& material() const { return material_; }
  Extension extension(const char* name) const { return find_extension(material_, name); }

  void set(const char* name, double value) { surface_.parameters[name] = float(value); }
  void set(const char* name, const Vec3f& value) { surface_.parameters[name] = value; }
  void set(const char* name, bool value) { surface_.parameters[name] = value; }
  /// The constant that was set; white, `fallback` otherwise.
  Vec3f color(const char* name) const;
  double number(const char* name, double fallback) const;

  /// Multiplies `input` by the texture; nothing if there is none.
  void connect(const char* input, const TextureUse& use, const Reading& reading);
  void connect_primvar(const char* input, const char* primvar, const char* output);
  /// Forgets the textures and primvars of `input`.
  void disconnect(const char* input) { surface_.inputConnections.erase(input); }
  /// Multiplies a colour's constant and all that is connected to it by itself.
  void square(const char* input);
  bool connected(const char* input) const { return surface_.inputConnections.contains(input); }

  /// `place` is below the material: "normalTexture".
  void warn(const char* code, const std::string& place, const std::string& text) const;
  void inform(const char* code, const std::string& place, const std::string& text) const;
  void error(const char* code, const std::string& place, const std::string& text) const;

  /// The network, without the nodes that nothing is connected to.
  MaterialNetwork finish();

 private:
  MaterialNode texture_node(const TextureUse& use, const Reading& reading) const;
  void connect_node(const char* input, const std::string& name, MaterialNode node, const char* output);

  const Document& document_;
  const tinygltf::Material& material_;
  const Path id_;
  const std::string element_;
  Report& report_;
  MaterialNode surface_;
  std::map<Path, MaterialNode> sources_;
};

}  // namespace alabaster::hd::gltf
