#include "delegate/view/load_options_json.h"

#include "delegate/description/quality_presets.h"

namespace alabaster::view {
namespace {

using nlohmann::json;

// Keys of which a description may have one only.
constexpr const char* kPlacements[] = {"transform", "lookAt", "motion"};

void add_settings(const json& settings, json* to) {
  // A preset counts more than the description's own settings.
  if (settings.contains("quality"))
    if (const auto* preset = hd::description::FindQualityPreset(settings["quality"].get<std::string>()))
      for (const auto& [key, value] : preset->settings) to->erase(key);
  to->update(settings);
}

void add_camera(const json& camera, json* to) {
  for (const char* key : kPlacements)
    if (camera.contains(key))
      for (const char* other : kPlacements) to->erase(other);
  to->update(camera);
}

void add_override(const std::string& assignment, json* document) {
  json part = json::parse(hd::description::OverrideText(assignment), nullptr, false);
  if (!part.is_object()) return;
  for_each_input_name(&part, [](json* name) { *name = std::filesystem::absolute(name->get<std::string>()).string(); });
  for (const auto& [key, value] : part.items()) {
    json& to = (*document)[key];
    if (to.is_null()) to = value.is_array() ? json::array() : json::object();
    if (key == "settings")
      add_settings(value, &to);
    else if (key == "camera")
      add_camera(value, &to);
    else
      to.insert(to.end(), value.begin(), value.end());
  }
}

// The description's own camera is called "camera".
bool is_own_camera(const std::string& name, const json& document) {
  if (name != "camera" || !document.contains("camera")) return false;
  const json& camera = document["camera"];
  return camera.size() > size_t(camera.contains("use"));
}

}  // namespace

void for_each_input_name(json* value, const std::function<void(json*)>& visit) {
  for (auto& [key, child] : value->items()) {
    const bool named =
        value->is_object() && (key == "file" || key == "texture:file" || key == "shaping:ies:file" || key == "ocio");
    // The names of products are those of files to write.
    if (named && child.is_string() && !child.get<std::string>().empty())
      visit(&child);
    else if (child.is_structured() && key != "products")
      for_each_input_name(&child, visit);
  }
}

void add_load_options(const hd::description::LoadOptions& options, json* document) {
  for (const std::string& assignment : options.overrides) add_override(assignment, document);
  if (!options.camera.empty() && !is_own_camera(options.camera, *document))
    (*document)["camera"] = {{"use", options.camera}};
  const char* const models = document->contains("gltf") ? "gltf" : "models";
  if (!document->contains(models)) return;
  for (json& model : (*document)[models]) {
    if (model.value("file", "").ends_with(".alab")) continue;  // it has one scene, at one time
    for (const auto& [key, value] :
         {std::pair{"scene", options.scene}, {"animation", options.animation}, {"variant", options.variant}})
      if (!value.empty()) model[key] = value;
    if (options.time) model["time"] = model.value("time", 0.0) + *options.time;
  }
}

}  // namespace alabaster::view
