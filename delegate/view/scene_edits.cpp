#include "delegate/view/scene_edits.h"

namespace alabaster::view {
namespace {

const hd::Token kDisney("AlabasterDisney");

hd::Path surface_path(const hd::MaterialNetwork& network) {
  const auto terminal = network.terminals.find("surface");
  return terminal == network.terminals.end() ? hd::Path() : terminal->second.upstreamNode;
}

// As `loaded` has it.
void restore(const std::map<hd::Token, hd::Value>& loaded, const std::string& parameter,
             std::map<hd::Token, hd::Value>* parameters) {
  const auto value = loaded.find(parameter);
  if (value == loaded.end()) {
    parameters->erase(parameter);
  } else {
    (*parameters)[parameter] = value->second;
  }
}

void forget(Changes* changes, const hd::Path& prim, const std::string& parameter) {
  const auto found = changes->find(prim);
  if (found == changes->end()) return;
  found->second.erase(parameter);
  if (found->second.empty()) changes->erase(found);
}

}  // namespace

hd::Value stored_value(const ParameterRow& row, const hd::Value& shown) {
  if (row.kind == RowKind::number || row.kind == RowKind::integer)
    return float(limited(row, shown.number_or(row.default_value.number_or(0))));
  if (row.kind == RowKind::color) {
    hd::Vec3f color = shown.get_or(hd::Vec3f(0));
    for (int i = 0; i < 3; ++i) color[i] = float(limited(row, double(color[i])));
    return color;
  }
  if (row.kind == RowKind::toggle) return shown.number_or(0) != 0;
  return shown.text_or("");
}

SceneEdits::SceneEdits(hd::host::RetainedSceneDelegate* scene)
    : scene_(scene), first_materials_(scene->GetMaterials()), first_lights_(scene->GetLights()) {
  for (const auto& [path, network] : first_materials_)
    if (surface(path)) materials_.push_back(path);
  for (const auto& [path, light] : first_lights_) lights_.push_back(path);
}

const hd::MaterialNode* SceneEdits::surface(const hd::Path& material) const {
  const auto found = scene_->GetMaterials().find(material);
  if (found == scene_->GetMaterials().end()) return nullptr;
  const auto node = found->second.nodes.find(surface_path(found->second));
  return node != found->second.nodes.end() && node->second.nodeTypeId == kDisney ? &node->second : nullptr;
}

std::string SceneEdits::light_type(const hd::Path& light) const {
  const auto found = first_lights_.find(light);
  return found == first_lights_.end() ? std::string() : found->second.type.str();
}

hd::Value SceneEdits::value(const hd::Path& prim, const ParameterRow& row) const {
  const std::map<hd::Token, hd::Value>* parameters = nullptr;
  if (const auto light = scene_->GetLights().find(prim); light != scene_->GetLights().end())
    parameters = &light->second.parameters;
  else if (const hd::MaterialNode* node = surface(prim))
    parameters = &node->parameters;
  if (!parameters) return row.default_value;
  const auto found = parameters->find(row.name);
  return found == parameters->end() ? row.default_value : found->second;
}

std::string SceneEdits::texture(const hd::Path& material, const std::string& parameter) const {
  const hd::MaterialNode* const node = surface(material);
  if (!node) return {};
  const auto inputs = node->inputConnections.find(parameter);
  if (inputs == node->inputConnections.end() || inputs->second.empty()) return {};
  const auto& nodes = scene_->GetMaterials().at(material).nodes;
  for (const hd::MaterialConnection& input : inputs->second) {
    const auto image = nodes.find(input.upstreamNode);
    if (image == nodes.end()) continue;
    const auto file = image->second.parameters.find("file");
    if (file != image->second.parameters.end())
      if (const auto* asset = file->second.get<hd::AssetPath>()) return asset->authored;
  }
  return "the mesh's own colour";  // a primvar
}

void SceneEdits::set(const hd::Path& prim, const ParameterRow& row, const hd::Value& shown) {
  const hd::Value value = stored_value(row, shown);
  if (first_lights_.contains(prim)) {
    hd::host::LightDescription light = scene_->GetLights().at(prim);
    light.parameters[row.name] = value;
    scene_->SetLight(prim, std::move(light));
    changed_lights_[prim][row.name] = value;
  } else if (surface(prim)) {
    hd::MaterialNetwork network = scene_->GetMaterials().at(prim);
    hd::MaterialNode& node = network.nodes[surface_path(network)];
    node.parameters[row.name] = value;
    node.inputConnections.erase(row.name);
    scene_->SetMaterial(prim, std::move(network));
    changed_materials_[prim][row.name] = value;
  }
}

void SceneEdits::reset(const hd::Path& prim, const std::string& parameter) {
  if (const auto first = first_lights_.find(prim); first != first_lights_.end()) {
    hd::host::LightDescription light = scene_->GetLights().at(prim);
    restore(first->second.parameters, parameter, &light.parameters);
    scene_->SetLight(prim, std::move(light));
    forget(&changed_lights_, prim, parameter);
  } else if (surface(prim)) {
    hd::MaterialNetwork network = scene_->GetMaterials().at(prim);
    const hd::Path path = surface_path(network);
    const hd::MaterialNode& loaded = first_materials_.at(prim).nodes.at(path);
    hd::MaterialNode& node = network.nodes[path];
    restore(loaded.parameters, parameter, &node.parameters);
    const auto inputs = loaded.inputConnections.find(parameter);
    if (inputs != loaded.inputConnections.end()) node.inputConnections[parameter] = inputs->second;
    scene_->SetMaterial(prim, std::move(network));
    forget(&changed_materials_, prim, parameter);
  }
}

bool SceneEdits::is_changed(const hd::Path& prim, const std::string& parameter) const {
  for (const Changes* changes : {&changed_materials_, &changed_lights_})
    if (const auto found = changes->find(prim); found != changes->end() && found->second.contains(parameter))
      return true;
  return false;
}

}  // namespace alabaster::view
