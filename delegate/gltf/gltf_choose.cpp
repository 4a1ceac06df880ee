// Scenes, animations and variants: which ones a document has, and which one is used.
#include <algorithm>
#include <charconv>

#include "delegate/gltf/gltf_document.h"

namespace alabaster::hd::gltf {
namespace {

std::vector<std::string> names_in(const Json& object, const char* array) {
  std::vector<std::string> names;
  if (object.contains(array))
    for (const Json& entry : object[array]) names.push_back(entry.value("name", std::string()));
  return names;
}

// A whole number is an index, anything else the first thing of that name. -1 after an error.
int find(const std::string& kind, const std::string& wanted, const std::vector<std::string>& names, Report& report) {
  size_t index = 0;
  const char* end = wanted.data() + wanted.size();
  const auto [stop, error] = std::from_chars(wanted.data(), end, index);
  const bool number = error == std::errc() && stop == end;
  if (!number) index = size_t(std::find(names.begin(), names.end(), wanted) - names.begin());
  if (index < names.size()) return int(index);
  std::string list;
  for (size_t n = 0; n < std::min(names.size(), size_t(20)); ++n)
    list += (n == 0 ? "" : ", ") + std::to_string(n) + (names[n].empty() ? "" : " '" + names[n].substr(0, 60) + "'");
  if (names.size() > 20) list += ", ...";
  report.error("choice", "",
               "has no " + kind + " '" + wanted.substr(0, 60) + "'; " +
                   (names.empty() ? "it has none at all" : "choose from " + list));
  return -1;
}

}  // namespace

void choose(const Json& root, const GltfOptions& options, Report& report, Document* document) {
  document->scenes = names_in(root, "scenes");
  for (std::string& name : names_in(root, "animations")) document->animations.push_back({std::move(name), 0});
  if (root.contains("extensions") && root["extensions"].contains("KHR_materials_variants"))
    document->variants = names_in(root["extensions"]["KHR_materials_variants"], "variants");
  if (!options.scene.empty()) {
    document->scene = find("scene", options.scene, document->scenes, report);
  } else if (!document->scenes.empty()) {
    document->scene = root.value("scene", 0);
  }
  if (!options.variant.empty()) document->variant = find("variant", options.variant, document->variants, report);
  if (!options.animation.empty()) {
    document->animation = find("animation", options.animation, names_in(root, "animations"), report);
  } else if (options.time && !document->animations.empty()) {
    document->animation = 0;
  }
  document->is_choice_wrong = report.failed();
}

}  // namespace alabaster::hd::gltf
