// Collects the network of one material: a node AlabasterDisney, and the textures and primvars that are connected to it.
#pragma once

#include "delegate/api/scene_types.h"
#include "delegate/gltf/gltf_document.h"
#include "delegate/gltf/gltf_material_table.h"

namespace alabaster::hd::gltf {

/// A texture as a material refers to it.
struct TextureUse {
  int index = -1;                   // in `textures`; -1: none
  int coordinates = 0;              // TEXCOORD_n
  double scale = 1;                 // of a normal texture
  const Json* transform = nullptr;  // KHR_texture_transform
};
/// The texture that `object` has under `name`.
TextureUse texture_in(const Json& object, const char* name);

class MaterialBuilder {
 public:
  /// `element` is the material's place in the document, for messages.
  MaterialBuilder(const Document& document, const Json& material, const Path& id, std::string element, Report& report);

  const Json& material() const { return material_; }
  /// An extension, kCore or "" for the material itself; null if the material lacks it.
  const Json& layer(std::string_view name) const;
  bool has(std::string_view name) const { return !layer(name).is_null(); }
  /// True if the material has the layer, and its first factor is not 0.
  bool has_weight(std::string_view layer) const;
  /// Factors of the table's rows; the row's fallback without.
  double number(std::string_view layer, std::string_view factor) const;
  Vec3f color(std::string_view layer, std::string_view factor) const;
  TextureUse texture(std::string_view of_layer, const char* name) const { return texture_in(layer(of_layer), name); }

  /// Sets the parameters that the rows of a layer become, and connects their textures.
  void emit(std::string_view layer);

  void set(const char* name, double value) { surface_.parameters[name] = float(value); }
  void set(const char* name, const Vec3f& value);
  void set(const char* name, bool value) { surface_.parameters[name] = value; }
  void set(const char* name, const char* word) { surface_.parameters[name] = Token(word); }
  /// The constant that was set; white, `fallback` otherwise.
  Vec3f color_set(const char* name) const;
  double number_set(const char* name, double fallback) const;

  /// Multiplies `input` by the texture; nothing if there is none.
  void connect(const char* input, const TextureUse& use, const Reading& reading);
  /// A tangent-space normal, its x and y scaled.
  void connect_normal(const char* input, const TextureUse& use);
  void connect_primvar(const char* input, const char* primvar, const char* output);
  /// Forgets the textures and primvars of `input`.
  void disconnect(const char* input) { surface_.inputConnections.erase(input); }
  /// Multiplies a colour's constant and all that is connected to it by itself.
  void square(const char* input);
  bool connected(const char* input) const { return surface_.inputConnections.contains(input); }

  /// `place` is below the material: "normalTexture".
  void say(Severity severity, const char* code, const std::string& place, const std::string& text) const {
    report_.send(severity, code, element_name(element_, place), text);
  }

  /// The network, without the nodes that nothing is connected to.
  MaterialNetwork finish();

 private:
  MaterialNode texture_node(const TextureUse& use, const Reading& reading) const;
  void connect_node(const char* input, const std::string& name, MaterialNode node, const char* output);

  const Document& document_;
  const Json& material_;
  const Path id_;
  const std::string element_;
  Report& report_;
  MaterialNode surface_;
  std::map<Path, MaterialNode> sources_;
};

}  // namespace alabaster::hd::gltf
