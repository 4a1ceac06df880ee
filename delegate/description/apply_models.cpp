#include <filesystem>

#include "delegate/description/apply_motion.h"
#include "delegate/description/load_state.h"
#include "delegate/description/placement.h"
#include "delegate/support/extension.h"

namespace alabaster::hd::description {
namespace {

// Paths of a model begin with its file's stem. A second model of the stem, or one whose paths an archive has, gets a
// root of its own.
Path root_for(const std::string& file, LoadState* state) {
  const std::string names = "/gltf/" + std::filesystem::path(file).stem().string();
  std::string root;
  for (int& copy = state->copies.emplace(names, 1).first->second;
       has_archive_prims_at(*state, root + names) || !state->model_names.insert(root + names).second;)
    root = "/copy" + std::to_string(++copy);
  return Path(root.empty() ? "/" : root);
}

gltf::GltfOptions options_of(const nlohmann::json& model, const LoadOptions& asked) {
  gltf::GltfOptions options;
  options.refine_level = model.value("refineLevel", options.refine_level);
  options.allow_outside = asked.allow_outside;
  options.scene = model.value("scene", "");
  options.animation = model.value("animation", "");
  options.variant = model.value("variant", "");
  if (model.contains("time") || asked.time) options.time = model.value("time", 0.0) + asked.time.value_or(0);
  return options;
}

// Has the animation sampled over the shutter, if that is open.
void sample_shutter(const LoadState& load, gltf::GltfOptions* model) {
  const nlohmann::json* camera = load.part("camera");
  const double open = camera ? camera->value("shutterOpen", 0.0) : 0;
  const double close = camera ? camera->value("shutterClose", 0.0) : 0;
  if (!(close > open)) return;
  model->time = model->time.value_or(0);
  model->frames_per_second = load.options.frames_per_second;
  model->shutter_open = open / model->frames_per_second;
  model->shutter_close = close / model->frames_per_second;
}

/// Where a description puts a model. A motion has its first place at time 0.
struct Placement {
  std::optional<Matrix4d> transform;
  TimeSamples<Matrix4d> motion;
};
Placement placement_of(LoadState& load, const std::string& pointer, const nlohmann::json& model) {
  Placement placement;
  if (model.contains("transform")) {
    placement.transform = to_transform(model["transform"]);
    if (!placement.transform)
      load.fail(pointer + "/transform",
                "The transform cannot be inverted or is not affine: the last column must be 0, 0, 0, 1, and no scale "
                "may be 0.");
  }
  if (!model.contains("motion")) return placement;
  if (model.contains("transform"))
    load.fail(pointer, "Give either a transform or a motion, which has one for each of its times.");
  placement.motion = to_motion(load, pointer + "/motion", model["motion"]);
  placement.transform = transform_at(placement.motion, 0);
  return placement;
}

// False after the report of a fault of the file, whose cause is noted.
bool add_gltf(LoadState& load, const nlohmann::json& model, const AssetPath& file, const Placement& placement) {
  const LoadOptions& asked = load.options;
  gltf::GltfOptions options = options_of(model, asked);
  options.root = root_for(file.resolved, &load);
  options.within = file.within;
  sample_shutter(load, &options);
  options.memory_limit = std::max(load.memory->left(), size_t(1));
  if (placement.transform) options.transform = *placement.transform;
  OpenModel open;
  open.time = model.value("time", 0.0);
  open.motion = placement.motion;
  const gltf::GltfSummary loaded = open.source.Load(file.resolved, options, load.scene, *load.sink);
  load.result->gltf.push_back(loaded);
  if (loaded.fault == gltf::GltfFault::choice && !(asked.scene + asked.animation + asked.variant).empty())
    load.note_cause(LoadCause::option);
  else if (!loaded.ok)
    load.note_cause(loaded.fault == gltf::GltfFault::out_of_memory ? LoadCause::out_of_memory : LoadCause::input);
  load.held.resize(load.held.bytes() + loaded.memory_bytes, file.resolved);
  if (!loaded.ok) return false;
  if (!open.motion.values.empty()) {
    move_prims(loaded.meshes, open.motion, load.scene);
    move_prims(loaded.cameras, open.motion, load.scene);
  }
  load.models.push_back(std::move(open));
  return true;
}

bool add_archive(LoadState& load, const std::string& pointer, const nlohmann::json& model, const AssetPath& file,
                 const Placement& placement) {
  for (const char* key : {"scene", "animation", "variant", "time", "refineLevel"})
    if (model.contains(key))
      load.fail(pointer_append(pointer, key),
                "An archive has one scene, at one time, with its own levels of refinement: leave it out.");
  return load_archive(file.resolved, {file.within, pointer.ends_with("/0"), placement.transform, placement.motion},
                      &load);
}

}  // namespace

void apply_models(LoadState& load) {
  const char* const list = load.part("models") ? "models" : "gltf";
  if (load.part("models") && load.part("gltf"))
    load.fail("/gltf", "It is the former name of 'models': put all models into that list.");
  bool ok = true;
  load.for_each_entry(list, [&](const std::string& pointer, const nlohmann::json& model) {
    const AssetPath file = load.asset(pointer + "/file", model["file"]);
    const Placement placement = placement_of(load, pointer, model);
    ok = (support::lower_extension(file.resolved) == ".alab" ? add_archive(load, pointer, model, file, placement)
                                                             : add_gltf(load, model, file, placement)) &&
         ok;
  });
  if (!ok) throw LoadFailed();
}

}  // namespace alabaster::hd::description
