#include <algorithm>
#include <filesystem>

#include "core/files/input_file.h"
#include "core/files/real_path.h"
#include "delegate/description/document_keys.h"
#include "delegate/description/layers.h"
#include "delegate/description/load_state.h"
#include "delegate/support/extension.h"
#include "delegate/support/json_bounds.h"
#include "delegate/support/process_usage.h"
#include "delegate/usd/usd_source.h"

namespace alabaster::hd::description {
namespace {

// A value takes a node of the document, and one of the table of its lines.
constexpr size_t kValueBytes = 300;

bool has_instances(const host::RetainedSceneDelegate& scene, const Path& prototype, const Path& instancer) {
  const auto found = scene.GetInstancers().find(instancer);
  if (found == scene.GetInstancers().end()) return instancer.empty();
  const auto indices = found->second.indices.find(prototype);
  return indices != found->second.indices.end() && !indices->second.empty();
}

bool draws_anything(const host::RetainedSceneDelegate& scene) {
  return std::any_of(scene.GetMeshes().begin(), scene.GetMeshes().end(), [&](const auto& entry) {
    const auto& [path, mesh] = entry;
    const bool has_shape = !mesh.topology.faceVertexCounts.empty() || !(mesh.type == Token("mesh"));
    return mesh.visible && has_shape && has_instances(scene, path, mesh.instancer);
  });
}

class Loader {
 public:
  explicit Loader(LoadState* state) : state_(*state) {
    state_.memory = std::make_shared<MemoryBudget>(support::default_memory_limit());
    state_.held = MemoryReservation(state_.memory, MemoryUse::scene);
  }

  void run(const std::string& file) {
    const DiagnosticSink& sink = *state_.sink;
    // Check the options alone: their faults are those of usage, and their memory limit counts while the file is read.
    JsonDocument given;
    require(read_options(state_.options, sink, &given) && check_description(given, sink), LoadCause::option);
    limit_memory(given);
    read_file(file);
    require(lay_over(given, state_.options, sink, &state_.document), LoadCause::option);
    apply_models(state_);
    edit_prims(state_);
    apply_camera(state_);
    apply_settings(state_);
    apply_products(state_);
    complete_scene(&state_);
    if (!draws_anything(*state_.scene))
      state_.report(Severity::warning, "scene.empty", file,
                    "There is nothing to draw: the scene has no visible mesh with faces. Name a model under "
                    "\"models\".");
  }

 private:
  [[noreturn]] void fail(const char* code, const std::string& where, const std::string& text) {
    state_.fail(LoadCause::input, code, where, text);
  }

  void require(bool reported_good, LoadCause otherwise) {
    if (reported_good) return;
    state_.note_cause(otherwise);
    throw LoadFailed();
  }

  void read_file(const std::string& file) {
    const InputFile input(file);
    if (input.fault() == InputFile::Fault::not_regular)
      fail("scene.kind", file,
           "It is not a regular file. A scene is a .gltf, .glb, .usd, .usda, .usdc, .usdz, .json or .alab file.");
    if (input.fault() == InputFile::Fault::missing)
      fail("scene.missing", file, "There is no such file. Check the name and the working folder.");
    if (input.fault() == InputFile::Fault::foreign) fail("scene.missing", file, input.reason());
    const std::string extension = support::lower_extension(file);
    if (extension == ".json") return read_description(file, input);
    if (extension == ".gltf" || extension == ".glb" || extension == ".alab" || usd::is_stage(extension)) {
      state_.document.origin = file;
      state_.document.set("/models/0/file", file, file);
      return;
    }
    fail(
        "scene.kind", file,
        "This is not a scene file: use .gltf, .glb, .usd, .usda, .usdc, .usdz, .json (a render description) or .alab.");
  }

  // The setting counts before anything is read. A file may only tighten what holds without it.
  void limit_memory(const JsonDocument& document) {
    const auto settings = document.value.find("settings");
    if (settings == document.value.end() || !settings->contains("memoryLimit")) return;
    const auto mib = (*settings)["memoryLimit"].get<double>();
    const bool is_option = document.is_of_option("/settings/memoryLimit");
    if (is_option) limit_is_given_ = true;
    if (mib >= 1 && mib < 0x1p40 && (is_option || !(limit_is_given_ || loosens_memory_limit(mib))))
      state_.memory->set_limit(static_cast<size_t>(mib) << 20);
  }

  void read_description(const std::string& file, const InputFile& input) {
    if (input && input.size() > kMaxDescriptionBytes)
      fail("description.size", file,
           "The file is larger than 64 MiB, too large for a render description. Geometry belongs in glTF files.");
    std::string json;
    if (!input || !input.read(&json)) fail("scene.read", file, "The file could not be read. Check its permissions.");
    const size_t values = support::bounds_of_json(json, json.size()).values;
    state_.read = MemoryReservation(state_.memory, MemoryUse::scene, 2 * json.size() + values * kValueBytes,
                                    "JSON of " + std::to_string(values) + " values");
    std::string problem;
    if (!parse_json(json, file, &state_.document, &problem)) fail("description.json", file, problem);
    require(check_description(state_.document, *state_.sink), LoadCause::input);
    expand_preset(&state_.document.value);
    limit_memory(state_.document);
    const std::filesystem::path folder = std::filesystem::path(file).parent_path();
    state_.folder = folder.empty() ? "." : folder.string();
    if (!state_.options.allow_outside) state_.within = allowed_folder(state_.folder);
  }

  LoadState& state_;
  bool limit_is_given_ = false;  // by an option
};

}  // namespace

void load_scene(const std::string& file, LoadState* state) {
  Loader(state).run(file);
}

}  // namespace alabaster::hd::description
