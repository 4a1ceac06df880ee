#include "delegate/view/scene_edits.h"

#include <algorithm>
#include <cmath>

namespace alabaster::view {
namespace {

using hd::host::Fields;

bool is_connection(const hd::Value& value) {
  return value.get<hd::Array<hd::Path>>() != nullptr;
}

// A field of that name. A parameter of a material may have two: a constant, and the images that are connected.
const hd::Value* field(const Fields& fields, const std::string& name, bool connected = false) {
  for (const auto& [known, value] : fields)
    if (known == name && is_connection(value) == connected) return &value;
  return nullptr;
}

std::string node_of(const std::string& output) {
  return output.substr(0, output.rfind('.'));
}

}  // namespace

hd::Value stored_value(const ParameterRow& row, const hd::Value& shown) {
  const double number = limited(row, shown.number_or(row.default_value.number_or(0)));
  if (row.kind == RowKind::number) return float(number);
  if (row.kind == RowKind::integer) return int64_t(std::llround(std::clamp(number, -0x1p62, 0x1p62)));
  if (row.kind == RowKind::color) {
    hd::Vec3f color = shown.get_or(hd::Vec3f(0));
    for (int i = 0; i < 3; ++i) color[i] = float(limited(row, double(color[i])));
    return color;
  }
  if (row.kind == RowKind::toggle) return shown.number_or(0) != 0;
  return shown.text_or("");
}

SceneEdits::SceneEdits(hd::host::RetainedSceneDelegate* scene) : scene_(scene) {
  for (const auto& [path, network] : scene->GetMaterials()) {
    const std::string node = hd::host::DisneySurface(path, network);
    if (!node.empty()) materials_.push_back(path), prims_[path] = {"", node + ".", hd::host::GetFields(path, network)};
  }
  for (const auto& [path, light] : scene->GetLights()) show_light(path, light);
}

void SceneEdits::show_light(const hd::Path& path, const hd::host::LightDescription& light) {
  lights_.insert(std::upper_bound(lights_.begin(), lights_.end(), path), path);
  prims_[path] = {light.type.str(), "", hd::host::GetFields(path, light)};
}

const SceneEdits::Prim* SceneEdits::find(const hd::Path& prim) const {
  const auto found = prims_.find(prim);
  return found == prims_.end() ? nullptr : &found->second;
}

const hd::Value* SceneEdits::change(const hd::Path& prim, const std::string& parameter) const {
  for (const Changes* changes : {&record_.materials, &record_.lights})
    if (const auto found = changes->find(prim); found != changes->end())
      if (const auto value = found->second.find(parameter); value != found->second.end()) return &value->second;
  return nullptr;
}

std::string SceneEdits::light_type(const hd::Path& prim) const {
  const Prim* const found = find(prim);
  return found ? found->light_type : "";
}

hd::Value SceneEdits::value(const hd::Path& prim, const ParameterRow& row) const {
  if (const hd::Value* const changed = change(prim, row.name)) return *changed;
  const Prim* const found = find(prim);
  const hd::Value* const loaded = found ? field(found->loaded, found->node + row.name) : nullptr;
  return loaded ? *loaded : row.default_value;
}

std::string SceneEdits::texture(const hd::Path& material, const std::string& parameter) const {
  const Prim* const found = change(material, parameter) ? nullptr : find(material);
  const hd::Value* const images = found ? field(found->loaded, found->node + parameter, true) : nullptr;
  if (!images) return {};
  for (const hd::Path& output : *images->get<hd::Array<hd::Path>>())
    if (const hd::Value* const file = field(found->loaded, node_of(output.str()) + ".file"))
      if (const auto* asset = file->get<hd::AssetPath>()) return asset->authored;
  return "the mesh's own colour";  // a primvar
}

std::string SceneEdits::set(const hd::Path& prim, const ParameterRow& row, const hd::Value& shown) {
  return apply(prim, row.name, stored_value(row, shown));
}

std::string SceneEdits::apply(const hd::Path& prim, const std::string& parameter, const hd::Value& value) {
  const Prim* const found = find(prim);
  if (!found) return "it is no prim that can be edited here";
  const std::string name = found->node + parameter;
  std::string fault = hd::host::EditPrim(scene_, prim, {{name, {}}, {name, value}}).fault;
  if (fault.empty()) (found->light_type.empty() ? record_.materials : record_.lights)[prim][parameter] = value;
  return fault;
}

std::string SceneEdits::reset(const hd::Path& prim, const std::string& parameter) {
  const Prim* const found = find(prim);
  if (!found) return "it is no prim that can be edited here";
  Fields fields{{found->node + parameter, {}}};
  for (const auto& loaded : found->loaded)
    if (loaded.first == fields[0].first || (parameter == "transform" && loaded.first == "transform:samples"))
      fields.push_back(loaded);
  std::string fault = hd::host::EditPrim(scene_, prim, fields).fault;
  if (!fault.empty()) return fault;
  for (Changes* changes : {&record_.materials, &record_.lights})
    if (const auto of_prim = changes->find(prim); of_prim != changes->end()) {
      of_prim->second.erase(parameter);
      if (of_prim->second.empty()) changes->erase(of_prim);
    }
  return fault;
}

hd::Matrix4d SceneEdits::transform(const hd::Path& light) const {
  const auto* const found = hd::host::FindPrim<hd::host::LightDescription>(scene_->GetPrims(), light);
  return found ? found->transform : hd::Matrix4d();
}

hd::Path SceneEdits::add_light(const hd::host::LightDescription& light) {
  const std::string type = light.type.str(), name = type.substr(0, type.find("Light"));
  const auto is_used = [&](const hd::Path& path) {
    return scene_->GetPrims().contains(path) || std::any_of(lights_.begin(), lights_.end(), [&](const hd::Path& other) {
             return scene_->GetName(other) == scene_->GetName(path);
           });
  };
  hd::Path path = hd::Path("/lights").append(name);
  for (int i = 2; is_used(path); ++i) path = hd::Path("/lights").append(name + "_" + std::to_string(i));
  scene_->SetLight(path, light);
  show_light(path, light);
  record_.added[path] = light;
  return path;
}

void SceneEdits::remove_light(const hd::Path& light) {
  if (record_.added.erase(light) == 0) return;
  scene_->Remove(light);
  std::erase(lights_, light);
  prims_.erase(light);
  record_.lights.erase(light);
}

EditRecord SceneEdits::made() const {
  EditRecord made = record_;
  for (Changes* changes : {&made.materials, &made.lights})
    std::erase_if(*changes, [this](const auto& of_prim) { return !find(of_prim.first); });
  return made;
}

std::vector<std::pair<hd::Path, std::string>> SceneEdits::restore(const EditRecord& wanted) {
  std::vector<std::pair<hd::Path, std::string>> faults;
  const EditRecord before = record_;
  const auto note = [&](const hd::Path& prim, const std::string& fault) {
    if (!fault.empty()) faults.emplace_back(prim, "is lost: " + fault);
  };
  for (const auto& [path, light] : before.added) remove_light(path);
  for (const Changes* changes : {&before.materials, &before.lights})
    for (const auto& [prim, values] : *changes)
      for (const auto& [parameter, value] : values)
        if (find(prim)) note(prim, reset(prim, parameter));
  record_ = made();
  for (const auto& [path, light] : wanted.added) {
    if (scene_->GetPrims().contains(path)) {
      note(path, "the scene has a prim of this path now");
      continue;
    }
    scene_->SetLight(path, light);
    show_light(path, light);
    record_.added[path] = light;
  }
  const std::vector<ParameterRow> rows = parameter_rows("lights");
  const auto suits = [&](const std::string& type, const std::string& parameter) {
    const auto row = std::find_if(rows.begin(), rows.end(), [&](const auto& r) { return r.name == parameter; });
    return type.empty() || row == rows.end() || row->applies_to.empty() ||
           std::find(row->applies_to.begin(), row->applies_to.end(), type) != row->applies_to.end();
  };
  for (const auto changes : {&EditRecord::materials, &EditRecord::lights})
    for (const auto& [prim, values] : wanted.*changes) {
      if (wanted.added.contains(prim) && !is_added(prim)) continue;
      if (!find(prim)) {
        (record_.*changes)[prim] = values;
        if (!(before.*changes).contains(prim))
          faults.emplace_back(prim, "waits until the scene has a material or light of this name again");
        continue;
      }
      for (const auto& [parameter, value] : values)
        note(prim, suits(light_type(prim), parameter) ? apply(prim, parameter, value)
                                                      : "a " + light_type(prim) + " has no '" + parameter + "'");
    }
  return faults;
}

}  // namespace alabaster::view
