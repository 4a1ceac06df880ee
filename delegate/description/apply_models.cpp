#include <cctype>
#include <filesystem>

#include "delegate/description/apply_motion.h"
#include "delegate/description/description_reader.h"
#include "delegate/description/placement.h"

namespace alabaster::hd::description {
namespace {

// Paths of a model begin with its file's stem. A second model of the stem, or one whose paths an archive has, gets a
// root of its own.
Path root_for(const std::string& file, LoadState* state) {
  const std::string names = "/gltf/" + std::filesystem::path(file).stem().string();
  std::string root;
  for (int copy = 2; has_archive_prims_at(*state, root + names) || !state->model_names.insert(root + names).second;
       ++copy)
    root = "/copy" + std::to_string(copy);
  return Path(root.empty() ? "/" : root);
}

bool is_archive(const std::string& file) {
  std::string extension = std::filesystem::path(file).extension();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension == ".alab";
}

// A choice of the command line takes the place of the model's own.
std::string chosen(const nlohmann::json& model, const char* key, const std::string& asked) {
  return asked.empty() ? model.value(key, std::string()) : asked;
}

gltf::GltfOptions options_of(const nlohmann::json& model, const LoadOptions& asked) {
  gltf::GltfOptions options;
  options.refine_level = model.value("refineLevel", options.refine_level);
  options.allow_outside = asked.allow_outside;
  options.scene = chosen(model, "scene", asked.scene);
  options.animation = chosen(model, "animation", asked.animation);
  options.variant = chosen(model, "variant", asked.variant);
  if (model.contains("time") || asked.time) options.time = model.value("time", 0.0) + asked.time.value_or(0);
  return options;
}

// The shutter that is asked for, else the description's own.
LoadOptions described_shutter(const Reader& reader) {
  LoadOptions options = reader.state().options;
  if (options.shutter || !reader.value().contains("camera")) return options;
  const nlohmann::json& camera = reader.value()["camera"];
  const double open = camera.value("shutterOpen", 0.0), close = camera.value("shutterClose", 0.0);
  options.shutter = {open, close};
  return options;
}

/// Where a description puts a model. A motion has its first place at time 0.
struct Placement {
  std::optional<Matrix4d> transform;
  TimeSamples<Matrix4d> motion;
};
bool read_placement(const Reader& reader, const std::string& pointer, const nlohmann::json& model,
                    Placement* placement) {
  if (model.contains("transform")) {
    placement->transform = to_transform(model["transform"]);
    if (!placement->transform)
      return reader.fail(pointer + "/transform",
                         "The transform cannot be inverted or is not affine: the last column must be 0, 0, 0, 1, and "
                         "no scale may be 0.");
  }
  if (!model.contains("motion")) return true;
  if (model.contains("transform"))
    return reader.fail(pointer, "Give either a transform or a motion, which has one for each of its times.");
  const auto samples = to_motion(reader, pointer + "/motion", model["motion"]);
  if (!samples) return false;
  placement->motion = *samples;
  placement->transform = transform_at(placement->motion, 0);
  return true;
}

bool add_gltf(const Reader& reader, const nlohmann::json& model, const AssetPath& file, const Placement& placement) {
  gltf::GltfOptions options = options_of(model, reader.state().options);
  options.root = root_for(file.resolved, &reader.state());
  options.within = file.within;
  sample_shutter(described_shutter(reader), &options);
  options.memory_limit = std::max(reader.state().memory->left(), size_t(1));
  if (placement.transform) options.transform = *placement.transform;
  OpenModel open;
  open.time = model.value("time", 0.0);
  open.motion = placement.motion;
  return load_model(file.resolved, options, std::move(open), &reader.state());
}

bool add_archive(const Reader& reader, const std::string& pointer, const AssetPath& file, const Placement& placement) {
  for (const char* key : {"scene", "animation", "variant", "time", "refineLevel"})
    if (reader.value().at(nlohmann::json::json_pointer(pointer)).contains(key))
      return reader.fail(pointer_append(pointer, key),
                         "An archive has one scene, at one time, with its own levels of refinement: leave it out.");
  return load_archive(file.resolved, {file.within, pointer.ends_with("/0"), placement.transform, placement.motion},
                      &reader.state());
}

}  // namespace

void sample_shutter(const LoadOptions& asked, gltf::GltfOptions* model) {
  if (!asked.shutter || !(asked.shutter->close > asked.shutter->open)) return;
  model->time = model->time.value_or(0);
  model->frames_per_second = asked.frames_per_second;
  model->shutter_open = asked.shutter->open / asked.frames_per_second;
  model->shutter_close = asked.shutter->close / asked.frames_per_second;
}

bool load_model(const std::string& file, const gltf::GltfOptions& options, OpenModel model, LoadState* state) {
  const gltf::GltfSummary loaded = model.source.Load(file, options, state->scene, *state->sink);
  state->result->gltf.push_back(loaded);
  const LoadOptions& asked = state->options;
  if (loaded.fault == gltf::GltfFault::choice && !(asked.scene + asked.animation + asked.variant).empty())
    state->note_cause(LoadCause::option);
  else if (!loaded.ok)
    state->note_cause(loaded.fault == gltf::GltfFault::out_of_memory ? LoadCause::out_of_memory : LoadCause::input);
  state->held.resize(state->held.bytes() + loaded.memory_bytes, file);
  if (!loaded.ok) return false;
  if (!model.motion.values.empty()) {
    move_prims(loaded.meshes, model.motion, state->scene);
    move_prims(loaded.cameras, model.motion, state->scene);
  }
  state->models.push_back(std::move(model));
  return true;
}

bool apply_models(const Reader& reader) {
  const char* const key = reader.value().contains("models") ? "models" : "gltf";
  const auto models = reader.value().find(key);
  if (models == reader.value().end()) return true;
  const std::string list = std::string("/") + key;
  if (list == "/models" && reader.value().contains("gltf"))
    return reader.fail("/gltf", "It is the former name of 'models': put all models into that list.");
  const LoadOptions& asked = reader.state().options;
  if (models->size() > 1 && !(asked.scene + asked.animation + asked.variant).empty()) {
    reader.state().note_cause(LoadCause::option);
    if (*reader.state().sink)
      (*reader.state().sink)({Severity::error, "gltf.choice", reader.place(list),
                              "There are several models: write scene, animation or variant beside each one's file."});
    return false;
  }
  bool ok = true;
  for (size_t i = 0; i < models->size(); ++i) {
    const nlohmann::json& model = (*models)[i];
    const std::string pointer = list + "/" + std::to_string(i);
    const AssetPath file = reader.asset(pointer + "/file", model["file"]);
    if (file.resolved.empty()) return false;
    Placement placement;
    if (!read_placement(reader, pointer, model, &placement)) return false;
    ok = (is_archive(file.resolved) ? add_archive(reader, pointer, file, placement)
                                    : add_gltf(reader, model, file, placement)) &&
         ok;
  }
  return ok;
}

}  // namespace alabaster::hd::description
