#include "delegate/description/load_state.h"
#include "delegate/looks/looks.h"
#include "delegate/support/color_space.h"
#include "delegate/support/json_values.h"

namespace alabaster::hd::description {
namespace {

using nlohmann::json;

// A value of the surface node, whose numbers are floats and never integers.
Value material_value(const json& value) {
  return value.is_number() ? Value(value.get<float>()) : support::value_of(value);
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

MaterialNode& add_texture(LoadState& load, const std::string& pointer, const json& texture, const Path& path,
                          MaterialNetwork* network) {
  MaterialNode& node = network->nodes[path];
  const std::string layer = texture.value("layer", "");
  node = {"AlabasterTexture", {{"file", load.image(pointer + "/file", texture["file"], layer)}}, {}};
  if (!layer.empty()) node.parameters["layer"] = Token(layer);
  node.parameters["sourceColorSpace"] = Token(texture.value("colorSpace", "auto"));
  node.parameters["wrapS"] = node.parameters["wrapT"] = Token(texture.value("wrap", "repeat"));
  node.parameters["st"] = Token(texture.value("st", "st"));
  return node;
}

void set_texture(LoadState& load, const std::string& pointer, const json& texture, const std::string& parameter,
                 const Path& surface, MaterialNetwork* network) {
  const std::string channel = texture.value("channel", "rgb");
  if (channel == "direction" && parameter != "anisotropicRotation")
    load.fail(pointer + "/channel", "Only anisotropicRotation reads an angle; name r, g, b or a.");
  const Path path = surface.append(parameter + "_texture");
  add_texture(load, pointer, texture, path, network);
  MaterialNode& disney = network->nodes[surface];
  // The constant multiplies the texture; without one it is 1.
  disney.parameters.erase(parameter);
  disney.parameters.erase(parameter + support::kColorSpace);
  if (texture.contains("scale")) disney.parameters[parameter] = material_value(texture["scale"]);
  disney.inputConnections[parameter] = {{path, Token(channel)}};
}

void set_bump(LoadState& load, const json& bump, const std::string& pointer, MaterialNetwork* network) {
  const Path surface = surface_of(*network);
  if (surface.empty()) load.fail(pointer, "The material has no Disney surface.");
  const Path path = surface.append("bump_texture");
  add_texture(load, pointer, bump, path, network).parameters["scale"] = Vec4f(bump.value("scale", 1.0f));
  network->nodes[surface].inputConnections.erase("normal");
  network->nodes[surface].inputConnections["bump"] = {{path, Token(bump.value("channel", "r"))}};
}

void set_displacement(LoadState& load, const json& displacement, const std::string& pointer, const Path& material,
                      MaterialNetwork* network) {
  const Path path = material.append("displacement"), image = path.append("texture");
  add_texture(load, pointer, displacement, image, network);
  const std::string space = displacement.value("space", "normal");
  if (space != "normal" && displacement.contains("channel"))
    load.fail(pointer + "/channel", "A vector takes all three channels; leave channel out.");
  MaterialNode& node = network->nodes[path];
  node = {"AlabasterDisplacement",
          {{"scale", displacement.value("scale", 1.0f)},
           {"midlevel", displacement.value("midlevel", 0.0f)},
           {"space", Token(space)}},
          {}};
  const std::string channel = space == "normal" ? displacement.value("channel", "r") : "rgb";
  node.inputConnections["displacement"] = {{image, Token(channel)}};
  network->terminals["displacement"] = {path, "displacement"};
}

void set_parameters(LoadState& load, const std::string& pointer, const json& parameters, MaterialNetwork* network) {
  const Path surface = surface_of(*network);
  if (surface.empty()) load.fail(pointer, "The material has no Disney surface; use replace instead of set.");
  for (const auto& [name, value] : parameters.items()) {
    if (value.is_object()) {
      set_texture(load, pointer_append(pointer, name), value, name, surface, network);
      continue;
    }
    MaterialNode& node = network->nodes[surface];
    node.inputConnections.erase(name);
    node.parameters[name] = material_value(value);
    node.parameters.erase(name + support::kColorSpace);
  }
}

void change_network(LoadState& load, const std::string& pointer, const json& entry, const Path& material,
                    MaterialNetwork* network) {
  for (const char* key : {"set", "replace"})
    if (entry.contains(key)) set_parameters(load, pointer_append(pointer, key), entry[key], network);
  if (entry.contains("bump")) set_bump(load, entry["bump"], pointer + "/bump", network);
  if (entry.contains("displacement"))
    set_displacement(load, entry["displacement"], pointer + "/displacement", material, network);
}

void apply_material_entry(LoadState& load, const std::string& pointer, const json& entry) {
  const bool set = entry.contains("set"), replace = entry.contains("replace");
  const bool relief = entry.contains("bump") || entry.contains("displacement");
  if (entry.contains("match") && entry.contains("name"))
    load.fail(pointer, "Either match existing materials or name a new one, not both.");
  if (set && replace) load.fail(pointer, "Give either set or replace, not both.");
  if (!set && !replace && !relief)
    load.fail(pointer, "There is nothing to change: add 'set', 'replace', 'bump' or 'displacement'.");
  std::vector<Path> paths;
  if (entry.contains("name")) {
    paths = {Path("/materials").append(entry["name"].get<std::string>())};
    if (load.scene->GetMaterials().contains(paths[0]))
      load.fail(pointer, "A material '" + paths[0].str() + "' already exists; match it instead.");
  } else {
    paths = find_prims(load, "material", entry["match"], pointer_append(pointer, "match"));
  }
  for (const Path& path : paths) {
    const auto known = load.scene->GetMaterials().find(path);
    const bool keep = !replace && known != load.scene->GetMaterials().end();
    // A look of another kind is changed as the AlabasterDisney that it is drawn as.
    const auto warn = [&](const char* code, const std::string& text) {
      load.report(Severity::warning, code, path.str(), text);
    };
    MaterialNetwork network = keep ? looks::ReadLook(known->second, warn) : plain_network(path);
    change_network(load, pointer, entry, path, &network);
    load.scene->SetMaterial(path, std::move(network));
    if (entry.contains("name")) add_name(load, "material", path);
  }
}

}  // namespace

void apply_materials(LoadState& load) {
  return load.for_each_entry("materials", [&](const std::string& pointer, const json& entry) {
    return apply_material_entry(load, pointer, entry);
  });
}

}  // namespace alabaster::hd::description
