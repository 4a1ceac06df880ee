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

// Null after an error.
MaterialNode* add_texture(const Reader& reader, const std::string& pointer, const json& texture, const Path& path,
                          MaterialNetwork* network) {
  const AssetPath file = reader.image(pointer + "/file", texture["file"]);
  if (file.resolved.empty()) return nullptr;
  MaterialNode node;
  node.nodeTypeId = "AlabasterTexture";
  node.parameters["file"] = file;
  node.parameters["sourceColorSpace"] = Token(texture.value("colorSpace", std::string("auto")));
  const Token wrap(texture.value("wrap", std::string("repeat")));
  node.parameters["wrapS"] = wrap;
  node.parameters["wrapT"] = wrap;
  node.parameters["st"] = Token(texture.value("st", std::string("st")));
  return &(network->nodes[path] = std::move(node));
}

bool set_texture(const Reader& reader, const std::string& pointer, const json& texture, const std::string& parameter,
                 const Path& surface, MaterialNetwork* network) {
  const std::string channel = texture.value("channel", std::string("rgb"));
  if (channel == "direction" && parameter != "anisotropicRotation")
    return reader.fail(pointer + "/channel", "Only anisotropicRotation reads an angle; name r, g, b or a.");
  const Path path = surface.append(parameter + "_texture");
  if (!add_texture(reader, pointer, texture, path, network)) return false;
  MaterialNode& disney = network->nodes[surface];
  // The constant multiplies the texture; without one it is 1.
  disney.parameters.erase(parameter);
  if (texture.contains("scale")) disney.parameters[parameter] = material_value(texture["scale"]);
  disney.inputConnections[parameter] = {{path, Token(channel)}};
  return true;
}

bool set_bump(const Reader& reader, const json& bump, const std::string& pointer, MaterialNetwork* network) {
  const Path surface = surface_of(*network);
  if (surface.empty()) return reader.fail(pointer, "The material has no Disney surface.");
  const Path path = surface.append("bump_texture");
  MaterialNode* const texture = add_texture(reader, pointer, bump, path, network);
  if (!texture) return false;
  texture->parameters["scale"] = Vec4f(bump.value("scale", 1.0f));
  network->nodes[surface].inputConnections.erase("normal");
  network->nodes[surface].inputConnections["bump"] = {{path, Token(bump.value("channel", std::string("r")))}};
  return true;
}

bool set_displacement(const Reader& reader, const json& displacement, const std::string& pointer, const Path& material,
                      MaterialNetwork* network) {
  const Path path = material.append("displacement"), image = path.append("texture");
  if (!add_texture(reader, pointer, displacement, image, network)) return false;
  const std::string space = displacement.value("space", std::string("normal"));
  if (space != "normal" && displacement.contains("channel"))
    return reader.fail(pointer + "/channel", "A vector takes all three channels; leave channel out.");
  MaterialNode node;
  node.nodeTypeId = "AlabasterDisplacement";
  node.parameters = {{"scale", displacement.value("scale", 1.0f)},
                     {"midlevel", displacement.value("midlevel", 0.0f)},
                     {"space", Token(space)}};
  const std::string channel = displacement.value("channel", std::string("r"));
  node.inputConnections["displacement"] = {{image, Token(space == "normal" ? channel : "rgb")}};
  network->nodes[path] = std::move(node);
  network->terminals["displacement"] = {path, "displacement"};
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

bool change_network(const Reader& reader, const std::string& pointer, const json& entry, const Path& material,
                    MaterialNetwork* network) {
  for (const char* key : {"set", "replace"})
    if (entry.contains(key) && !set_parameters(reader, pointer_append(pointer, key), entry[key], network)) return false;
  return (!entry.contains("bump") || set_bump(reader, entry["bump"], pointer + "/bump", network)) &&
         (!entry.contains("displacement") ||
          set_displacement(reader, entry["displacement"], pointer + "/displacement", material, network));
}

bool apply_entry(const Reader& reader, const std::string& pointer, const json& entry) {
  const bool set = entry.contains("set"), replace = entry.contains("replace");
  const bool relief = entry.contains("bump") || entry.contains("displacement");
  if (entry.contains("match") && entry.contains("name"))
    return reader.fail(pointer, "Either match existing materials or name a new one, not both.");
  if (set && replace) return reader.fail(pointer, "Give either set or replace, not both.");
  if (!set && !replace && !relief)
    return reader.fail(pointer, "There is nothing to change: add 'set', 'replace', 'bump' or 'displacement'.");
  std::vector<Path> paths;
  if (entry.contains("name")) {
    paths = {Path("/materials").append(entry["name"].get<std::string>())};
    if (reader.scene().GetMaterials().contains(paths[0]))
      return reader.fail(pointer, "A material '" + paths[0].str() + "' already exists; match it instead.");
  } else {
    paths = find_prims(reader, PrimKind::material, entry["match"], pointer_append(pointer, "match"));
  }
  for (const Path& path : paths) {
    const auto known = reader.scene().GetMaterials().find(path);
    const bool keep = !replace && known != reader.scene().GetMaterials().end();
    MaterialNetwork network = keep ? known->second : plain_network(path);
    if (!change_network(reader, pointer, entry, path, &network)) return false;
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
