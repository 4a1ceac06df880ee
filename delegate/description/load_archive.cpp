#include <algorithm>
#include <memory>
#include <set>

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

template <class Visit>
void for_each_path(const host::RetainedSceneDelegate& scene, const Visit& visit) {
  const auto each = [&](const auto& prims) {
    for (const auto& prim : prims) visit(prim.first);
  };
  each(scene.GetMeshes()), each(scene.GetInstancers()), each(scene.GetMaterials()), each(scene.GetLights());
  each(scene.GetCameras()), each(scene.GetAllRenderSettings());
}

// A file may lower the limit of memory, and not raise it.
void drop_loose_limits(const std::string& file, const LoadState& state, host::RetainedSceneDelegate* scene) {
  const std::map<Path, RenderSettingsDescription> all = scene->GetAllRenderSettings();
  for (auto [path, settings] : all) {
    const auto limit = settings.settings.find("memoryLimit");
    if (limit == settings.settings.end() || !loosens_memory_limit(limit->second.number_or(0))) continue;
    if (limit->second.number_or(0) != 0 && *state.sink)
      (*state.sink)({Severity::warning, "archive.memoryLimit", file + ": " + path.str(),
                     "A file cannot raise the limit of memory, so this is not taken. Raise it with --memory-limit "
                     "(hosts: setting memoryLimit)."});
    settings.settings.erase(limit);
    scene->SetRenderSettings(path, std::move(settings));
  }
}

void add_prims(const host::RetainedSceneDelegate& from, host::RetainedSceneDelegate* to) {
  for (const auto& [path, prim] : from.GetMeshes()) to->SetMesh(path, prim);
  for (const auto& [path, prim] : from.GetInstancers()) to->SetInstancer(path, prim);
  for (const auto& [path, prim] : from.GetMaterials()) to->SetMaterial(path, prim);
  for (const auto& [path, prim] : from.GetLights()) to->SetLight(path, prim);
  for (const auto& [path, prim] : from.GetCameras()) to->SetCamera(path, prim);
}

// Settings that differ from the first ones in size and crop alone are planned from these again, so that edits change
// both.
std::optional<FramePlan> plan_of(const RenderSettingsDescription& settings, RenderSettingsDescription first) {
  FramePlan frame;
  if (settings.width != first.width || settings.height != first.height)
    frame.resolution = Vec2i(settings.width, settings.height);
  if (settings.crop != first.crop || frame.resolution) frame.crop = settings.crop;
  first.width = settings.width, first.height = settings.height;
  first.crop = settings.crop, first.products = settings.products;
  return settings == first ? std::optional(frame) : std::nullopt;
}

// Settings that are not planned from the first ones stay prims of the scene.
void take_settings(const std::map<Path, RenderSettingsDescription>& all, const Path& chosen, LoadState* state) {
  if (all.empty()) return;
  const auto first = all.contains(chosen) ? all.find(chosen) : all.begin();
  state->settings_path = first->first, state->archive_settings = true;
  state->settings = first->second;
  state->settings.products.clear();
  const Path& camera = first->second.camera;
  if (state->scene->GetCameras().contains(camera))
    state->camera.use = camera.str();
  else if (!camera.empty() && *state->sink)
    (*state->sink)({Severity::warning, "archive.camera", first->first.str(),
                    "They name the camera '" + camera.str() + "', which the archive does not have."});
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

bool begins_with(const std::string& path, const std::string& names) {
  return path == names || path.starts_with(names + "/");
}

bool collides(const host::RetainedSceneDelegate& read, const LoadState& state) {
  bool found = false;
  for_each_path(read, [&](const Path& path) {
    found = found || state.archive_paths.contains(path) ||
            std::any_of(state.model_names.begin(), state.model_names.end(),
                        [&](const std::string& names) { return begins_with(path.str(), names); });
  });
  return found;
}

}  // namespace

bool has_archive_prims_at(const LoadState& state, const std::string& path) {
  return std::any_of(state.archive_paths.begin(), state.archive_paths.end(),
                     [&](const Path& prim) { return begins_with(prim.str(), path); });
}

Path free_path(const LoadState& state, const std::string& wanted) {
  const auto is_taken = [&](const std::string& path) {
    return has_archive_prims_at(state, path) ||
           std::any_of(state.model_names.begin(), state.model_names.end(),
                       [&](const std::string& names) { return begins_with(names, path); });
  };
  std::string path = wanted;
  for (int copy = 2; is_taken(path); ++copy) path = wanted + std::to_string(copy);
  return Path(path);
}

bool load_archive(const std::string& file, const ArchiveModel& model, LoadState* state) {
  const LoadOptions& asked = state->options;
  if (!(asked.scene + asked.animation + asked.variant).empty()) {
    state->note_cause(LoadCause::option);
    if (*state->sink)
      (*state->sink)({Severity::error, "archive.choice", file,
                      "An archive has one scene, without animations and variants: leave the choice out."});
    return false;
  }
  archive::ReadOptions options = {asked.allow_outside, model.within};
  options.memory_limit = std::max(state->memory->left(), size_t(1));
  auto read = std::make_unique<host::RetainedSceneDelegate>();
  archive::ReadResult result = archive::ReadArchive(file, read.get(), *state->sink, options);
  if (result.ok && collides(*read, *state)) {
    options.root = free_path(*state, "/copy").str();
    read = std::make_unique<host::RetainedSceneDelegate>();
    result = archive::ReadArchive(file, read.get(), {}, options);
  }
  if (result.out_of_memory) state->note_cause(LoadCause::out_of_memory);
  if (!result.ok) return false;
  state->held.resize(state->held.bytes() + result.memory_bytes, file);
  if (model.transform) place_prims(*model.transform, read.get());
  if (!model.motion.values.empty()) {
    move_prims(keys_of(read->GetMeshes()), model.motion, read.get());
    move_prims(keys_of(read->GetCameras()), model.motion, read.get());
  }
  drop_loose_limits(file, *state, read.get());
  add_prims(*read, state->scene);
  for_each_path(*read, [&](const Path& path) { state->archive_paths.insert(path); });
  state->result->archives.push_back({file, keys_of(read->GetLights()), keys_of(read->GetMeshes())});
  if (!model.is_first) return true;
  state->has_archive = true;
  take_settings(read->GetAllRenderSettings(), result.info.settings, state);
  state->result->color_config = result.info.color_config.resolved;
  state->result->color_config_within = result.info.color_config.within;
  return true;
}

}  // namespace alabaster::hd::description
