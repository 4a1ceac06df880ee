#include <algorithm>

#include "delegate/archive/archive.h"
#include "delegate/description/apply_motion.h"
#include "delegate/description/description_reader.h"

namespace alabaster::hd::description {
namespace {

void place(const Matrix4d& transform, Matrix4d* own, TimeSamples<Matrix4d>* samples) {
  *own = *own * transform;
  for (Matrix4d& sample : samples->values) sample = sample * transform;
}

// Instancers place their prototypes and the instancers below them.
void place_prims(const Matrix4d& transform, host::RetainedSceneDelegate* scene) {
  const auto meshes = scene->GetMeshes();
  for (auto [path, mesh] : meshes) {
    if (!mesh.instancer.empty()) continue;
    place(transform, &mesh.transform, &mesh.transformSamples);
    scene->SetMesh(path, std::move(mesh));
  }
  const auto instancers = scene->GetInstancers();
  for (auto [path, instancer] : instancers) {
    if (!instancer.parent.empty()) continue;
    place(transform, &instancer.transform, &instancer.transformSamples);
    scene->SetInstancer(path, std::move(instancer));
  }
  const auto lights = scene->GetLights();
  for (auto [path, light] : lights) {
    light.transform = light.transform * transform;
    scene->SetLight(path, std::move(light));
  }
  const auto cameras = scene->GetCameras();
  for (auto [path, camera] : cameras) {
    place(transform, &camera.transform, &camera.transformSamples);
    scene->SetCamera(path, std::move(camera));
  }
}

template <class Map>
std::vector<Path> keys_of(const Map& map) {
  std::vector<Path> keys;
  for (const auto& entry : map) keys.push_back(entry.first);
  return keys;
}

void add_prims(const host::RetainedSceneDelegate& from, host::RetainedSceneDelegate* to) {
  for (const auto& [path, prim] : from.GetMeshes()) to->SetMesh(path, prim);
  for (const auto& [path, prim] : from.GetInstancers()) to->SetInstancer(path, prim);
  for (const auto& [path, prim] : from.GetMaterials()) to->SetMaterial(path, prim);
  for (const auto& [path, prim] : from.GetLights()) to->SetLight(path, prim);
  for (const auto& [path, prim] : from.GetCameras()) to->SetCamera(path, prim);
}

// Settings that are the first ones but for size and crop are planned from these again, so that edits count for both.
std::optional<FramePlan> plan_of(const RenderSettingsDescription& settings, RenderSettingsDescription first) {
  FramePlan frame;
  if (settings.width != first.width || settings.height != first.height)
    frame.resolution = Vec2i(settings.width, settings.height);
  if (settings.crop != first.crop || frame.resolution) frame.crop = settings.crop;
  first.width = settings.width, first.height = settings.height;
  first.crop = settings.crop, first.products = settings.products;
  return settings == first ? std::optional(frame) : std::nullopt;
}

// Leaves in the scene the settings that are planned from no others.
void take_settings(const std::map<Path, RenderSettingsDescription>& all, const Path& chosen, LoadState* state) {
  if (all.empty()) return;
  const auto first = all.contains(chosen) ? all.find(chosen) : all.begin();
  state->settings_path = first->first;
  state->settings = first->second;
  state->settings.products.clear();
  if (state->scene->GetCameras().contains(first->second.camera)) state->camera.use = first->second.camera.str();
  const auto add_products = [&](const FramePlan& frame, const RenderSettingsDescription& settings) {
    for (const RenderProduct& product : settings.products) state->products.push_back({frame, product, true});
  };
  add_products({}, first->second);
  for (const auto& [path, settings] : all) {
    if (path == first->first) continue;
    if (const auto frame = plan_of(settings, first->second))
      add_products(*frame, settings);
    else
      state->scene->SetRenderSettings(path, settings);
  }
}

}  // namespace

bool load_archive(const std::string& file, const ArchiveModel& model, LoadState* state) {
  const LoadOptions& asked = state->options;
  if (!(asked.scene + asked.animation + asked.variant).empty()) {
    state->note_cause(LoadCause::option);
    if (*state->sink)
      (*state->sink)({Severity::error, "archive.choice", file,
                      "An archive has one scene, without animations and variants: leave the choice out."});
    return false;
  }
  host::RetainedSceneDelegate read;
  const archive::ReadResult result =
      archive::ReadArchive(file, &read, *state->sink,
                           {asked.allow_outside, model.within, model.root, std::max(state->memory->left(), size_t(1))});
  if (result.out_of_memory) state->note_cause(LoadCause::out_of_memory);
  if (!result.ok) return false;
  state->held.resize(state->held.bytes() + result.memory_bytes, file);
  if (model.transform) place_prims(*model.transform, &read);
  if (!model.motion.values.empty()) {
    move_prims(keys_of(read.GetMeshes()), model.motion, &read);
    move_prims(keys_of(read.GetCameras()), model.motion, &read);
  }
  add_prims(read, state->scene);
  state->result->archives.push_back({file, keys_of(read.GetLights())});
  if (state->has_archive || !model.root.empty()) return true;
  state->has_archive = true;
  take_settings(read.GetAllRenderSettings(), result.info.settings, state);
  state->result->color_config = result.info.color_config.resolved;
  state->result->color_config_within = result.info.color_config.within;
  return true;
}

}  // namespace alabaster::hd::description
