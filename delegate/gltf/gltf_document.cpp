#include "delegate/gltf/gltf_document.h"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <filesystem>
#include <set>

#include "core/files/real_path.h"
#include "delegate/gltf/gltf_schema.h"
#include "delegate/support/process_usage.h"

namespace alabaster::hd::gltf {
namespace {

std::vector<std::string> names_in(const Json& object, const char* array) {
  std::vector<std::string> names;
  for (const Json& entry : at(object, array)) names.push_back(entry.value("name", std::string()));
  return names;
}

// The first thing of that name; else a whole number is an index. -1 after an error.
int find_choice(const std::string& kind, const std::string& wanted, const std::vector<std::string>& names,
                Report& report) {
  auto index = size_t(std::find(names.begin(), names.end(), wanted) - names.begin());
  if (index == names.size()) {
    const char* end = wanted.data() + wanted.size();
    const auto [stop, error] = std::from_chars(wanted.data(), end, index);
    if (error != std::errc() || stop != end) index = names.size();
  }
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

// glTF 1.0 has objects by name where 2.0 has arrays. A document that calls itself 2.0 may have one by mistake.
bool is_version_1(const Json& root) {
  const Json& version = at(at(root, "asset"), "version");
  const auto is_object = [&](const char* name) { return at(root, name).is_object(); };
  constexpr const char* kLists[] = {"accessors", "animations", "buffers",    "bufferViews", "cameras",  "images",
                                    "materials", "meshes",     "nodes",      "programs",    "samplers", "scenes",
                                    "shaders",   "skins",      "techniques", "textures"};
  const auto objects = std::count_if(std::begin(kLists), std::end(kLists), is_object);
  if (version.is_number()) return version.get<double>() >= 1 && version.get<double>() < 2;
  if (version.is_string() && (version == "1" || version.get_ref<const std::string&>().starts_with("1."))) return true;
  return objects > (version.is_string() && version != "0.8" ? 1 : 0);
}

void check_version(const Json& root, Report& report) {
  for (const char* name : {"version", "minVersion"}) {
    if (!root["asset"].contains(name)) continue;
    const std::string version = root["asset"][name].get<std::string>();
    int major = 0, minor = 0, length = 0;
    const bool parsed = std::sscanf(version.c_str(), "%4d.%4d%n", &major, &minor, &length) == 2;
    const std::string element = element_name("asset", name);
    if (!parsed || size_t(length) != version.size()) {
      report.error("version", element,
                   std::string("'").append(version, 0, 40).append("' is not a version; write \"2.0\""));
    } else if (major != 2 || (minor > 0 && std::string_view(name) == "minVersion")) {
      report.error("version", element, "glTF " + version + " is not supported, only 2.0; convert the file");
    }
  }
}

// False after an error.
bool check_root(Json& root, Report& report) {
  if (is_version_1(root)) {
    report.error("version", "asset.version", kIsVersion1);
    return false;
  }
  check_structure(root, report);
  if (!report.failed()) check_version(root, report);
  return !report.failed();
}

void report_extensions(const Json& root, Report& report) {
  for (const std::string& name : root.value("extensionsUsed", std::set<std::string>()))
    if (!reads_extension(name))
      report.warning("extension.ignored", "extensionsUsed", name + " is not supported and is ignored");
}

bool parse_model(const Json& root, Report& report, Document* document) {
  std::string errors;
  if (tinygltf::parse_checked(root, &document->model, &errors)) return true;
  // tinygltf's words end in line breaks. This is a fault that our own checks missed.
  std::replace(errors.begin(), errors.end(), '\n', ' ');
  report.error("parse", "", "cannot be parsed as glTF (" + errors.substr(0, 200) + "); export the file again");
  return false;
}

// Scenes, animations and variants: which ones a document has, and which one is used.
void choose(const Json& root, const host::SourceOptions& options, Report& report, Document* document) {
  host::SceneFacts& has = document->facts;
  has.scenes = names_in(root, "scenes");
  for (std::string& name : names_in(root, "animations")) has.animations.push_back({std::move(name), 0});
  has.variants = names_in(extension_of(root, "KHR_materials_variants"), "variants");
  if (!options.scene.empty()) {
    document->scene = find_choice("scene", options.scene, has.scenes, report);
  } else if (!has.scenes.empty()) {
    document->scene = root.value("scene", 0);
  }
  if (!options.variant.empty()) document->variant = find_choice("variant", options.variant, has.variants, report);
  if (!options.animation.empty()) {
    document->animation = find_choice("animation", options.animation, names_in(root, "animations"), report);
  } else if (options.is_timed && !has.animations.empty()) {
    document->animation = 0;
  }
  document->is_choice_wrong = report.failed();
}

// Gives every primitive that has a material for the variant that material.
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

}  // namespace

bool read_document(const std::string& file, const host::SourceOptions& options, Report& report, Document* document) {
  document->file = file;
  document->base.folder = std::filesystem::path(file).parent_path().string();
  if (!options.allow_outside) document->base.within = allowed_folder(document->base.folder);
  if (!options.within.empty() && !is_within(document->base.within, options.within)) {
    report.error("file", "", outside_text(document->base.folder));
    return false;
  }
  const size_t limit = options.memory_limit ? options.memory_limit : support::default_memory_limit();
  document->memory = MemoryReservation(std::make_shared<MemoryBudget>(limit), MemoryUse::scene);
  Container container;
  if (!read_container({file, options.within}, &document->memory, report, &container)) return false;
  Json& root = container.root;
  if (!check_root(root, report)) return false;
  choose(root, options, report, document);
  if (report.failed()) return false;
  if (container.is_glb && !container.binary_chunk && root.contains("buffers"))
    report.warning("glb.no_binary", "buffers",
                   "the GLB has no binary chunk: its buffers are other files or base64 text");
  load_buffers(root, container.binary_chunk, report, document);
  if (report.failed()) return false;
  load_accessors(root, report, document);
  if (report.failed()) return false;
  check_meshes(root, report, document);
  check_nodes(root, report, document);
  if (report.failed()) return false;
  check_animations(root, report, document);
  if (report.failed()) return false;
  load_images(root, report, document);
  choose_image_light(root, report, document);
  report_extensions(root, report);
  if (document->variant >= 0) apply_variant(root, size_t(document->variant));
  if (root.contains("materials")) document->materials = std::move(root["materials"]);
  return !report.failed() && parse_model(root, report, document);
}

}  // namespace alabaster::hd::gltf
