#include "delegate/support/preview_surface.h"

#include <numbers>
#include <optional>

#include "delegate/support/lookup.h"
#include "delegate/support/surface_formulas.h"

namespace alabaster::hd::support {
namespace {

/// An input of UsdPreviewSurface that is a parameter of AlabasterDisney.
struct SurfaceInput {
  const char* name;
  const char* parameter;
  Value initial;  // the specification's default; empty: it is AlabasterDisney's, too
};
const SurfaceInput kInputs[] = {{"diffuseColor", "baseColor", Vec3f(0.18f)},
                                {"emissiveColor", "emission", {}},
                                {"metallic", "metallic", {}},
                                {"roughness", "roughness", {}},
                                {"clearcoat", "coat", {}},
                                {"clearcoatRoughness", "coatRoughness", 0.01f},
                                {"opacity", "opacity", {}},
                                {"opacityThreshold", "opacityThreshold", {}},
                                {"ior", "ior", {}}};

Value value_or(const std::map<Token, Value>& parameters, const char* name, const Value& otherwise) {
  const auto found = parameters.find(name);
  return found == parameters.end() || found->second.empty() ? otherwise : found->second;
}

class PreviewTranslation {
 public:
  PreviewTranslation(const MaterialNetwork& from, const WarnNetwork& warn) : from_(from), warn_(warn) {}

  MaterialNetwork run(const Path& id, const MaterialNode& surface) {
    MaterialNode& disney = to_.nodes[id];
    disney.nodeTypeId = "AlabasterDisney";
    to_.terminals["surface"] = {id, "out"};
    const bool specular = value_or(surface.parameters, "useSpecularWorkflow", 0).number_or(0) != 0;
    for (const SurfaceInput& input : kInputs) {
      if (specular && Token(input.name) == Token("metallic")) continue;
      read_input(surface, input, &disney);
    }
    if (specular) read_specular_color(surface, &disney);
    if (const auto normal = connected(surface, "normal")) disney.inputConnections["normal"] = {*normal};
    read_displacement(id, surface);
    return std::move(to_);
  }

 private:
  void read_input(const MaterialNode& surface, const SurfaceInput& input, MaterialNode* disney) {
    if (const auto connection = connected(surface, input.name)) {
      disney->inputConnections[input.parameter] = {*connection};
      return;
    }
    const Value value = value_or(surface.parameters, input.name, input.initial);
    if (!value.empty()) disney->parameters[input.parameter] = value;
  }

  // F0 itself. AlabasterDisney's specularColor scales that of its ior.
  void read_specular_color(const MaterialNode& surface, MaterialNode* disney) {
    disney->inputConnections.erase("ior");
    disney->parameters["ior"] = 1.5f;
    disney->parameters["specularColor"] = Vec3f(kSpecularColorOfOne);
    if (const auto connection = connected(surface, "specularColor"))
      disney->inputConnections["specularColor"] = {*connection};
    else
      disney->parameters["specularColor"] =
          value_or(surface.parameters, "specularColor", Vec3f(0)).get_or(Vec3f(0)) * kSpecularColorOfOne;
  }

  void read_displacement(const Path& id, const MaterialNode& surface) {
    if (const auto connection = connected(surface, "displacement")) {
      const Path node = id.append("displacement");
      to_.nodes[node] = {"AlabasterDisplacement", {}, {{"displacement", {*connection}}}};
      to_.terminals["displacement"] = {node, "out"};
    } else if (value_or(surface.parameters, "displacement", 0.0f).number_or(0) != 0) {
      warn_("material.displacement", "a constant displacement is not read; connect a texture");
    }
  }

  /// The connection in nodes that are read; none: the input is not connected, or (reported) cannot be read.
  std::optional<MaterialConnection> connected(const MaterialNode& surface, const char* input) {
    const MaterialConnection* const from = first_in(surface.inputConnections, input);
    if (!from) return std::nullopt;
    const MaterialNode* const node = find_in(from_.nodes, from->upstreamNode);
    if (!node) {
      warn_("material.node", std::string(input) + " is connected to " + from->upstreamNode.str() +
                                 ", which does not exist; its constant is used");
      return std::nullopt;
    }
    const std::string& type = node->nodeTypeId.str();
    if (type == "UsdUVTexture") {
      if (!add_texture(from->upstreamNode, *node)) return std::nullopt;
      return *from;
    }
    if (type.rfind("UsdPrimvarReader_", 0) == 0) return primvar(input, *node);
    warn_("material.node",
          std::string(input) + " is connected to a node of unknown type '" + type + "'; its constant is used");
    return std::nullopt;
  }

  std::optional<MaterialConnection> primvar(const char* input, const MaterialNode& reader) {
    const std::string name = value_or(reader.parameters, "varname", "").text_or("");
    if (name != "displayColor" && name != "displayOpacity") {
      warn_("material.primvar", std::string(input) + " reads primvar '" + name +
                                    "', but surfaces read displayColor and displayOpacity alone; its constant is used");
      return std::nullopt;
    }
    to_.nodes[name].nodeTypeId = "AlabasterPrimvar";
    return MaterialConnection{name, name == "displayColor" ? "rgb" : "a"};
  }

  bool add_texture(const Path& id, const MaterialNode& texture) {
    if (to_.nodes.contains(id)) return true;
    MaterialNode read{"AlabasterTexture", {}, {}};
    for (const char* name : {"file", "sourceColorSpace", "scale", "bias"})
      if (const Value value = value_or(texture.parameters, name, {}); !value.empty()) read.parameters[name] = value;
    if (!read.parameters.contains("file")) {
      warn_("material.texture.file", id.str() + " has no file; its input's constant is used");
      return false;
    }
    for (const char* name : {"wrapS", "wrapT"}) {
      const std::string wrap = value_or(texture.parameters, name, "useMetadata").text_or("");
      read.parameters[name] = wrap == "useMetadata" ? "black" : wrap;  // files carry none
    }
    read_coordinates(texture, &read);
    to_.nodes[id] = std::move(read);
    return true;
  }

  // Input `st` is connected to a reader of a primvar, maybe through a transform.
  void read_coordinates(const MaterialNode& texture, MaterialNode* read) {
    const MaterialConnection* connection = first_in(texture.inputConnections, "st");
    const MaterialNode* node = connection ? find_in(from_.nodes, connection->upstreamNode) : nullptr;
    if (node && node->nodeTypeId == Token("UsdTransform2d")) {
      place(*node, read);
      connection = first_in(node->inputConnections, "in");
      node = connection ? find_in(from_.nodes, connection->upstreamNode) : nullptr;
    }
    if (node && node->nodeTypeId == Token("UsdPrimvarReader_float2")) {
      read->parameters["st"] = value_or(node->parameters, "varname", "st").text_or("st");
    } else if (connection) {
      warn_("material.texture.st", "texture coordinates come from " + connection->upstreamNode.str() +
                                       ", which is no UsdPrimvarReader_float2; primvar st is used");
    }
  }

  // UsdTransform2d: uv' = R (scale * uv) + translation, with v up.
  static void place(const MaterialNode& transform, MaterialNode* read) {
    const auto degrees = static_cast<float>(value_or(transform.parameters, "rotation", 0.0f).number_or(0));
    const Vec2f scale = value_or(transform.parameters, "scale", {}).get_or(Vec2f(1, 1));
    const Vec2f translation = value_or(transform.parameters, "translation", {}).get_or(Vec2f(0, 0));
    place_image(scale, degrees * std::numbers::pi_v<float> / 180, translation, read);
  }

  const MaterialNetwork& from_;
  const WarnNetwork& warn_;
  MaterialNetwork to_;
};

}  // namespace

MaterialNetwork TranslatePreviewSurface(const MaterialNetwork& network, const WarnNetwork& warn) {
  const auto terminal = network.terminals.find("surface");
  if (terminal == network.terminals.end()) return network;
  const auto surface = network.nodes.find(terminal->second.upstreamNode);
  if (surface == network.nodes.end() || !(surface->second.nodeTypeId == Token("UsdPreviewSurface"))) return network;
  return PreviewTranslation(network, warn).run(surface->first, surface->second);
}

}  // namespace alabaster::hd::support
