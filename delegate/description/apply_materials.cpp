#include "delegate/description/description_reader.h"
#include "delegate/description/name_match.h"

namespace alabaster::hd::description {
namespace {

using nlohmann::json;

// A value of the surface node, whose numbers are floats and never integers.
Value material_value(const json& value) {
  return value.is_number() ? Value(value.get<float>()) : to_value(value);
}

MaterialNetwork plain_network(const Path& material) {
  const Path surface = material.append("surface");
  MaterialNetwork network;
  network.nodes[surface].nodeTypeId = "AlabasterDisney";
  network.terminals["surface"] = {surface, "surface"};
  return network;
}

Path surface_of(const MaterialNetwork& network) {
  const auto terminal = network.terminals.find("surface");
  if (terminal == network.terminals.end()) return {};
  const auto node = network.nodes.find(terminal->second.upstreamNode);
  const bool ours = node != network.nodes.end() && node->second.nodeTypeId == Token("AlabasterDisney");
  return ours ? node->first : Path();
}

bool set_texture(const Reader& reader, const std::string& pointer, const json& texture, const std::string& parameter,
                 const Path& surface, MaterialNetwork* network) {
  const AssetPath file = reader.image(pointer + "/file", texture["file"]);
  if (file.resolved.empty()) return false;
  const Path path = surface.append(parameter + "_texture");
  MaterialNode node;
  node.nodeTypeId = "AlabasterTexture";
  node.parameters["file"] = file;
  node.parameters["sourceColorSpace"] = Token(texture.value("colorSpace", std::string("auto")));
  const Token wrap(texture.value("wrap", std::string("repeat")));
  node.parameters["wrapS"] = wrap;
  node.parameters["wrapT"] = wrap;
  node.parameters["st"] = Token(texture.value("st", std::string("st")));
  network->nodes[path] = std::move(node);
  MaterialNode& disney = network->nodes[surface];
  // The constant multiplies the texture; without one it is 1.
  disney.parameters.erase(parameter);
  if (texture.contains("scale")) disney.parameters[parameter] = material_value(texture["scale"]);
  disney.inputConnections[parameter] = {{path, Token(texture.value("channel", std::string("rgb")))}};
  return true;
}

bool set_parameters(const Reader& reader, const std::string& pointer, const json& parameters,
                    MaterialNetwork* network) {
  const Path surface = surface_of(*network);
  if (surface.empty()) return reader.fail(pointer, "The material has no Disney surface; use replace instead of set.");
  for (const auto& [name, value] : parameters.items()) {
    if (value.is_object()) {
      if (!set_texture(reader, pointer_append(pointer, name), value, name, surface, network)) return false;
      continue;
    }
    MaterialNode& node = network->nodes[surface];
    node.inputConnections.erase(name);
    node.parameters[name] = material_value(value);
  }
  return true;
}

bool apply_entry(const Reader& reader, const std::string& pointer, const json& entry) {
  const bool set = entry.contains("set"), replace = entry.contains("replace");
  if (entry.contains("match") && entry.contains("name"))
    return reader.fail(pointer, "Either match existing materials or name a new one, not both.");
  if (set && replace) return reader.fail(pointer, "Give either set or replace, not both.");
  if (!set && !replace) return reader.fail(pointer, "There is nothing to change: add 'set' or 'replace'.");
  const char* key = set ? "set" : "replace";
  const std::string inner = pointer_append(pointer, key);
  std::vector<Path> paths;
  if (entry.contains("name")) {
    paths = {Path("/materials").append(entry["name"].get<std::string>())};
    if (reader.scene().GetMaterials().count(paths[0]))
      return reader.fail(pointer, "A material '" + paths[0].str() + "' already exists; match it instead.");
  } else {
    paths = find_prims(reader, PrimKind::material, entry["match"], pointer_append(pointer, "match"));
  }
  for (const Path& path : paths) {
    const auto known = reader.scene().GetMaterials().find(path);
    const bool keep = set && known != reader.scene().GetMaterials().end();
    MaterialNetwork network = keep ? known->second : plain_network(path);
    if (!set_parameters(reader, inner, entry[key], &network)) return false;
    reader.scene().SetMaterial(path, std::move(network));
  }
  return !paths.empty();
}

}  // namespace

bool apply_materials(const Reader& reader) {
  const auto entries = reader.value().find("materials");
  if (entries == reader.value().end()) return true;
  for (size_t i = 0; i < entries->size(); ++i)
    if (!apply_entry(reader, "/materials/" + std::to_string(i), (*entries)[i])) return false;
  return true;
}

}  // namespace alabaster::hd::description
