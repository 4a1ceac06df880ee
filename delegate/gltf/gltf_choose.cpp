// Scenes, animations and variants: which ones a document has, and which one is used.
#include <algorithm>
#include <charconv>

#include "delegate/gltf/gltf_document.h"

namespace alabaster::hd::gltf {
namespace {

std::vector<std::string> names_in(const Json& object, const char* array) {
  std::vector<std::string> names;
  for (const Json& entry : at(object, array)) names.push_back(entry.value("name", std::string()));
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
  GltfSummary& has = document->summary;
  has.scenes = names_in(root, "scenes");
  for (std::string& name : names_in(root, "animations")) has.animations.push_back({std::move(name), 0});
  has.variants = names_in(extension_of(root, "KHR_materials_variants"), "variants");
  if (!options.scene.empty()) {
    document->scene = find("scene", options.scene, has.scenes, report);
  } else if (!has.scenes.empty()) {
    document->scene = root.value("scene", 0);
  }
  if (!options.variant.empty()) document->variant = find("variant", options.variant, has.variants, report);
  if (!options.animation.empty()) {
    document->animation = find("animation", options.animation, names_in(root, "animations"), report);
  } else if (options.time && !has.animations.empty()) {
    document->animation = 0;
  }
  document->is_choice_wrong = report.failed();
}

void apply_variant(Json& root, size_t variant) {
  for (size_t m = 0; m < at(root, "meshes").size(); ++m)
    for (Json& primitive : root["meshes"][m]["primitives"]) {
      const Json& mappings = at(extension_of(primitive, "KHR_materials_variants"), "mappings");
      const auto has_variant = [&](const Json& mapping) {
        return std::find(mapping["variants"].begin(), mapping["variants"].end(), variant) != mapping["variants"].end();
      };
      const auto found = std::find_if(mappings.begin(), mappings.end(), has_variant);
      if (found != mappings.end()) primitive["material"] = (*found)["material"];
    }
}

}  // namespace alabaster::hd::gltf
