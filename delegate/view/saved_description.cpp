#include "delegate/view/saved_description.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "core/files/input_file.h"
#include "delegate/archive/archive.h"
#include "delegate/support/json_values.h"
#include "delegate/support/output_file.h"

namespace alabaster::view {
namespace {

namespace fs = std::filesystem;
using hd::support::json_of;
using nlohmann::json;

const hd::Path kBackdrop("/studio/backdrop");
const hd::Path kDome("/lights/dome");  // of --dome

// Paths as patterns that match nothing else.
std::string literal(const hd::Path& path) {
  std::string pattern;
  for (const char c : path.str()) {
    if (std::string("*?[\\").find(c) != std::string::npos) pattern += '\\';
    pattern += c;
  }
  return pattern;
}

std::string last_name(const hd::Path& path) {
  return path.str().substr(path.str().rfind('/') + 1);
}

json camera_of(const hd::CameraDescription& camera, const hd::host::SceneInfo& scene) {
  json entry = json::object();
  const hd::TimeSamples<hd::Matrix4d>& motion = camera.transformSamples;
  for (size_t i = 0; i < motion.values.size() && motion.values.size() > 1; ++i)
    entry["motion"].push_back({{"time", motion.times[i]}, {"transform", json_of(motion.values[i])}});
  if (!entry.contains("motion")) entry["transform"] = json_of(camera.transform);
  for (const hd::host::FieldRow& row : hd::host::ParameterRows("camera"))
    if (const auto given = camera.parameters.find(row.name); given != camera.parameters.end())
      entry[row.name] = row.in_millimetres
                            ? json(hd::description::Millimetres(float(given->second.number_or(0)), scene))
                            : json_of(given->second);
  return entry;
}

class Description {
 public:
  Description(const ViewChanges& changes, const std::string& file, const hd::DiagnosticSink& sink)
      : c_(changes), file_(file), folder_(fs::absolute(file).lexically_normal().parent_path()), sink_(sink) {}

  bool write() {
    if (!file_.ends_with(".json")) return fail("A render description is a .json file: give it such a name.");
    if (!read_base()) return false;
    if (!c_.ocio.empty() && c_.ocio != c_.loaded->color_config)
      document_["ocio"] = placed(fs::absolute(c_.ocio).string());
    add_backdrop();
    for (const auto& [path, values] : c_.materials)
      if (!is_backdrop(path)) add("materials", path, values, true);
    add_lights();
    if (c_.camera) document_["camera"] = camera_of(*c_.camera, c_.loaded->info);
    for (const auto& [name, value] : c_.settings) document_["settings"][name] = json_of(value);
    for (const auto& [name, bytes] : companions_)
      if (is_input((folder_ / name).string())) return false;
    if (is_input(file_) || (!backdrop_.empty() && is_input((folder_ / backdrop_).string()))) return false;
    for (const auto& [name, bytes] : companions_)
      if (!write_file((folder_ / name).string(), bytes)) return false;
    if (!backdrop_.empty() && !write_backdrop()) return false;
    const std::string text = hd::support::readable_json(document_) + "\n";
    if (!write_file(file_, {text.begin(), text.end()})) return false;
    if (outside_ && sink_)
      sink_({hd::Severity::info, "view.outside", file_,
             "It names files outside of its folder: render it with --allow-outside."});
    return true;
  }

 private:
  bool fail(const std::string& text) {
    if (sink_) sink_({hd::Severity::error, "view.description", file_, text});
    return false;
  }

  bool is_input(const std::string& name) const { return c_.is_input && c_.is_input(name); }

  bool write_file(const std::string& name, const std::vector<uint8_t>& bytes) {
    const std::string problem = hd::support::WriteOutputFile(name, bytes);
    return problem.empty() || fail(name + " could not be written: " + problem + ".");
  }

  bool read_base() {
    base_ = fs::absolute(c_.scene_file).lexically_normal();
    std::error_code error;
    if (fs::equivalent(base_, file_, error))
      return fail("That is the scene itself, which must stay as it is: choose another name.");
    std::string text = json{{"models", {{{"file", base_.filename().string()}}}}}.dump();
    if (base_.string().ends_with(".json")) {
      const InputFile file(base_);
      if (!file || !file.read(&text)) text.clear();
    }
    const auto place = [this](const std::string& name) { return placed(name); };
    document_ = json::parse(hd::description::WithOptions(text, c_.options, place), nullptr, false);
    if (!document_.is_object())
      return fail("The scene's description, " + base_.string() + ", is gone or no longer whole: restore it.");
    return true;
  }

  // A name beside the scene as one beside the new description, or an absolute one.
  std::string placed(const std::string& name) {
    const fs::path full = (base_.parent_path() / name).lexically_normal();
    const fs::path inside = full.lexically_relative(folder_);
    if (!inside.empty() && *inside.begin() != "..") return inside.string();
    outside_ = true;
    return full.string();
  }

  void add(const char* kind, const hd::Path& path, const std::map<std::string, hd::Value>& values, bool set) {
    json entry{{"match", literal(path)}};
    for (const auto& [name, value] : values) (set ? entry["set"] : entry)[name] = json_of(value);
    document_[kind].push_back(std::move(entry));
  }

  std::string companion(const std::string& suffix, std::vector<uint8_t> bytes) {
    std::string name = fs::path(file_).stem().string() + suffix;
    companions_.emplace_back(name, std::move(bytes));
    return name;
  }

  bool is_backdrop(const hd::Path& material) const {
    const auto mesh = c_.scene->GetMeshes().find(kBackdrop);
    return mesh != c_.scene->GetMeshes().end() && mesh->second.material == material;
  }

  void add_backdrop() {
    if (!c_.scene->GetMeshes().contains(kBackdrop)) return;
    for (const auto& model : c_.loaded->models)
      if (std::find(model.meshes.begin(), model.meshes.end(), kBackdrop) != model.meshes.end()) return;
    backdrop_ = fs::path(file_).stem().string() + "_backdrop.alab";
    document_[document_.contains("gltf") ? "gltf" : "models"].push_back({{"file", backdrop_}});
  }
  bool write_backdrop() {
    const hd::host::MeshDescription& mesh = c_.scene->GetMeshes().at(kBackdrop);
    hd::host::RetainedSceneDelegate scene;
    scene.SetMesh(kBackdrop, mesh);
    scene.SetMaterial(mesh.material, c_.scene->GetMaterials().at(mesh.material));
    const std::string file = (folder_ / backdrop_).string();
    const std::string problem = hd::archive::WriteArchive(file, scene.GetPrims());
    return problem.empty() || fail(file + " could not be written: " + problem + ".");
  }

  // The paths of the lights that the scene's own files bring.
  std::set<hd::Path> own_lights() const {
    std::set<hd::Path> own;
    for (const auto& model : c_.loaded->models) own.insert(model.lights.begin(), model.lights.end());
    if (document_.contains("lights"))
      for (const json& light : document_["lights"])
        if (light.contains("name")) own.insert(hd::Path("/lights").append(light["name"].get<std::string>()));
    return own;
  }

  // The dome of the options, which may have the path of one that it has replaced.
  bool is_new_dome(const hd::Path& path) const { return !c_.options.dome.empty() && path == kDome; }

  json value_of_light(const hd::Value& value) {
    const auto* const image = value.get<hd::AssetPath>();
    if (!image) return json_of(value);
    return image->bytes ? companion("_dome.hdr", *image->bytes) : placed(fs::absolute(image->resolved).string());
  }

  void add_lights() {
    const std::set<hd::Path> own = own_lights();
    const auto& lights = c_.scene->GetLights();
    bool replaced = false;
    for (const hd::Path& path : own)
      if (!lights.contains(path) || is_new_dome(path))
        replaced = true, add("lights", path, {{"intensity", 0.0f}}, false);
    for (const auto& [path, light] : lights) {
      if (own.contains(path) && !is_new_dome(path)) continue;
      replaced = true;
      const std::string name = last_name(path) + (own.contains(path) ? "_2" : "");
      json entry{{"name", name}, {"type", light.type.str()}, {"transform", json_of(light.transform)}};
      for (const auto& [parameter, value] : light.parameters) entry[parameter.str()] = value_of_light(value);
      document_["lights"].push_back(std::move(entry));
    }
    for (const auto& [path, values] : c_.lights)
      if (own.contains(path) && !is_new_dome(path)) add("lights", path, values, false);
    if (replaced) document_["settings"]["studio"] = "off";
  }

  const ViewChanges& c_;
  const std::string file_;
  const fs::path folder_;
  const hd::DiagnosticSink& sink_;
  fs::path base_;
  json document_;
  std::vector<std::pair<std::string, std::vector<uint8_t>>> companions_;
  std::string backdrop_;  // the name of its archive; empty: there is none
  bool outside_ = false;
};

}  // namespace

bool WriteDescription(const ViewChanges& changes, const std::string& file, const hd::DiagnosticSink& sink) {
  try {
    return Description(changes, file, sink).write();
  } catch (const std::exception& e) {
    if (sink)
      sink({hd::Severity::error, "view.description", file, std::string("It could not be written: ") + e.what()});
    return false;
  }
}

}  // namespace alabaster::view
