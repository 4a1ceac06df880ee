#include <algorithm>
#include <cctype>
#include <filesystem>

#include "core/files/input_file.h"
#include "delegate/description/description_reader.h"
#include "delegate/description/render_description.h"
#include "delegate/description/schema_check.h"
#include "delegate/support/process_usage.h"

namespace alabaster::hd::description {
namespace {

// A value takes a node of the document, and one of the table of its lines.
constexpr size_t kValueBytes = 300;

std::string lower_extension(const std::string& file) {
  std::string extension = std::filesystem::path(file).extension();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

bool has_instances(const host::RetainedSceneDelegate& scene, const Path& prototype, const Path& instancer) {
  const auto found = scene.GetInstancers().find(instancer);
  if (found == scene.GetInstancers().end()) return instancer.empty();
  const auto indices = found->second.indices.find(prototype);
  return indices != found->second.indices.end() && !indices->second.empty();
}

bool draws_anything(const host::RetainedSceneDelegate& scene) {
  return std::any_of(scene.GetMeshes().begin(), scene.GetMeshes().end(), [&](const auto& entry) {
    const auto& [path, mesh] = entry;
    return mesh.visible && !mesh.topology.faceVertexCounts.empty() && has_instances(scene, path, mesh.instancer);
  });
}

class Loader {
 public:
  explicit Loader(LoadState* state) : sink_(*state->sink), state_(*state) {
    state_.memory = std::make_shared<MemoryBudget>(support::default_memory_limit());
    state_.held = MemoryReservation(state_.memory, MemoryUse::scene);
  }

  bool run(const std::string& file, const LoadOptions& options) {
    state_.options = options;
    for (const std::string& assignment : options.overrides) {
      JsonDocument document;
      std::string problem;  // reported when it is applied
      if (assignment.starts_with("memoryLimit=") && override_document(assignment, &document, &problem))
        limit_memory(document.value, true);
    }
    if (!load_file(file)) return false;
    if (!apply_options(options)) {
      state_.note_cause(LoadCause::option);
      return false;
    }
    if (options.shutter) {
      state_.camera.parameters["shutterOpen"] = static_cast<float>(options.shutter->open);
      state_.camera.parameters["shutterClose"] = static_cast<float>(options.shutter->close);
    }
    if (!complete_scene(&state_)) return false;
    if (!draws_anything(*state_.scene) && sink_)
      sink_({Severity::warning, "scene.empty", file,
             "There is nothing to draw: the scene has no visible mesh with faces. Name a model under \"models\"."});
    return true;
  }

 private:
  bool apply_options(const LoadOptions& options) {
    for (const std::string& assignment : options.overrides)
      if (!apply_override(assignment)) return false;
    return (options.dome.empty() || replace_domes(options.dome)) &&
           (options.camera.empty() || choose_camera(options.camera));
  }

  bool fail(const char* code, const std::string& where, const std::string& text) {
    if (sink_) sink_({Severity::error, code, where, text});
    return false;
  }

  bool load_file(const std::string& file) {
    const InputFile input(file);
    if (input.fault() == InputFile::Fault::not_regular)
      return fail("scene.kind", file, "It is not a regular file. A scene is a .gltf, .glb, .json or .alab file.");
    if (input.fault() == InputFile::Fault::missing)
      return fail("scene.missing", file, "There is no such file. Check the name and the working folder.");
    const std::string extension = lower_extension(file);
    if (extension == ".json") return load_description(file, input);
    if (extension == ".gltf" || extension == ".glb") {
      const LoadOptions& o = state_.options;
      gltf::GltfOptions options;
      options.scene = o.scene;
      options.animation = o.animation;
      options.variant = o.variant;
      options.time = o.time;
      options.allow_outside = o.allow_outside;
      sample_shutter(o, &options);
      options.memory_limit = state_.memory->left();
      return load_model(file, options, {}, &state_);
    }
    if (extension == ".alab") return load_archive(file, {}, &state_);
    const bool is_usd = extension == ".usd" || extension == ".usda" || extension == ".usdc" || extension == ".usdz";
    return fail("scene.kind", file,
                is_usd ? "Files of OpenUSD are rendered by its own hosts, such as usdrecord, with the plug-in of "
                         "delegate/hydra/README.md. Here use .gltf, .glb, .json (a render description) or .alab."
                       : "This is not a scene file: use .gltf, .glb, .json (a render description) or .alab.");
  }

  // As the setting of a description or an override says, which counts before any description. A description may only
  // tighten what holds without it.
  void limit_memory(const nlohmann::json& description, bool overrides) {
    const auto settings = description.find("settings");
    if (settings == description.end() || !settings->contains("memoryLimit") || limit_is_given_) return;
    limit_is_given_ = overrides;
    const nlohmann::json& mib = (*settings)["memoryLimit"];
    if (mib.is_number() && mib.get<double>() >= 1 && mib.get<double>() < 0x1p40 &&
        (overrides || !loosens_memory_limit(mib.get<double>())))
      state_.memory->set_limit(mib.get<size_t>() << 20);
  }

  bool load_description(const std::string& file, const InputFile& input) {
    if (input && input.size() > kMaxDescriptionBytes)
      return fail(
          "description.size", file,
          "The file is larger than 64 MiB, too large for a render description. Geometry belongs in glTF files.");
    std::string json;
    if (!input || !input.read(&json))
      return fail("scene.read", file, "The file could not be read. Check its permissions.");
    const auto values = static_cast<size_t>(
        std::count_if(json.begin(), json.end(), [](char c) { return c == ',' || c == '[' || c == '{'; }));
    const MemoryReservation memory(state_.memory, MemoryUse::scene, 2 * json.size() + values * kValueBytes,
                                   "JSON of " + std::to_string(values) + " values");
    JsonDocument document;
    std::string problem;
    if (!parse_json(json, file, &document, &problem)) return fail("description.json", file, problem);
    if (!check_description(document, sink_)) return false;
    limit_memory(document.value, false);
    const std::filesystem::path folder = std::filesystem::path(file).parent_path();
    return apply(std::move(document), folder.empty() ? "." : folder.string());
  }

  bool apply(JsonDocument document, const std::string& folder) {
    const Reader reader(document, folder, &state_);
    const bool ok = apply_models(reader) && apply_materials(reader) && apply_meshes(reader) && apply_lights(reader) &&
                    apply_camera(reader) && apply_settings(reader) && apply_products(reader);
    if (document.value.contains("meshes") || document.value.contains("lights"))
      state_.documents.push_back({std::move(document), folder});
    return ok;
  }

  bool apply_override(const std::string& assignment) {
    JsonDocument document;
    std::string problem;
    if (!override_document(assignment, &document, &problem)) return fail("override", assignment, problem);
    return check_description(document, sink_) && apply(std::move(document), "");
  }

  bool replace_domes(const std::string& dome) {
    std::vector<Path> old;
    for (const auto& [path, light] : state_.scene->GetLights())
      if (light.type == Token("domeLight")) old.push_back(path);
    for (const Path& path : old) state_.scene->Remove(path);
    if (!is_utf8(dome)) return fail("dome", dome, "It is not UTF-8, as names of files in a scene are.");
    JsonDocument document = dome_document(dome);
    return check_description(document, sink_) && apply(std::move(document), "");
  }

  // Takes the requested camera as it is, because the description's changes were meant for another one.
  bool choose_camera(const std::string& name) {
    if (name == "camera" && (state_.camera.transform || !state_.camera.parameters.empty())) return true;
    JsonDocument document;
    document.origin = "camera " + name;
    document.value = nlohmann::json{{"camera", {{"use", name}}}};
    state_.camera = {};
    return apply(std::move(document), "");
  }

  const DiagnosticSink& sink_;
  LoadState& state_;
  bool limit_is_given_ = false;  // by an override
};

}  // namespace

bool load_scene(const std::string& file, const LoadOptions& options, LoadState* state) {
  return Loader(state).run(file, options);
}

std::string OverrideText(const std::string& assignment) {
  JsonDocument document;
  std::string problem;
  return override_document(assignment, &document, &problem) ? document.value.dump() : std::string();
}

}  // namespace alabaster::hd::description
