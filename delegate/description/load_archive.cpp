#include <algorithm>
#include <memory>

#include "delegate/archive/archive.h"
#include "delegate/description/apply_motion.h"
#include "delegate/description/load_state.h"
#include "delegate/support/lookup.h"

namespace alabaster::hd::description {
namespace {

using support::keys_of;

void place_prims(const Matrix4d& transform, host::RetainedSceneDelegate* scene) {
  const auto place = [&transform](auto& prim) {
    bool is_placed = false;  // instancers place their prototypes and the instancers below them
    if constexpr (requires { prim.instancer; }) is_placed = !prim.instancer.empty();
    if constexpr (requires { prim.parent; }) is_placed = !prim.parent.empty();
    if (is_placed) return;
    if constexpr (requires { prim.transform; }) prim.transform = prim.transform * transform;
    if constexpr (requires { prim.transformSamples; })
      for (Matrix4d& sample : prim.transformSamples.values) sample = sample * transform;
  };
  for (const auto& [path, prim] : scene->GetPrims()) {
    host::PrimDescription placed = prim;
    std::visit(place, placed);
    scene->Set(path, std::move(placed));
  }
}

// A file may lower the limit of memory, and not raise it.
void drop_loose_limits(const std::string& file, const LoadState& state, host::RetainedSceneDelegate* scene) {
  for (const auto& [path, prim] : scene->GetAllRenderSettings()) {
    RenderSettingsDescription settings = prim;
    const auto limit = settings.settings.find("memoryLimit");
    if (limit == settings.settings.end() || !loosens_memory_limit(limit->second.number_or(0))) continue;
    if (limit->second.number_or(0) != 0)
      state.report(Severity::warning, "archive.memoryLimit", file + ": " + path.str(),
                   refused_limit_text(state.options));
    settings.settings.erase(limit);
    scene->SetRenderSettings(path, std::move(settings));
  }
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
void take_settings(const host::PrimsOf<RenderSettingsDescription>& all, const Path& chosen, LoadState* state) {
  if (all.empty()) return;
  const auto first = all.contains(chosen) ? all.find(chosen) : all.begin();
  state->settings_path = first->first, state->archive_settings = true;
  state->settings = first->second;
  state->settings.products.clear();
  const Path& camera = first->second.camera;
  if (state->scene->GetCameras().contains(camera))
    state->camera.use = camera.str();
  else if (!camera.empty())
    state->report(Severity::warning, "archive.camera", first->first.str(),
                  "They name the camera '" + camera.str() + "', which the archive does not have.");
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

bool collides(const host::Prims& prims, const LoadState& state) {
  return std::any_of(prims.begin(), prims.end(), [&](const auto& prim) {
    return state.archive_paths.contains(prim.first) || is_of_model(state, prim.first.str());
  });
}

// True if a set of texts or paths has that path, or one below it.
template <class Set>
bool has_at_or_below(const Set& paths, const std::string& path) {
  if (paths.contains(path)) return true;
  const auto next = paths.lower_bound(path + "/");
  if (next == paths.end()) return false;
  if constexpr (std::is_same_v<typename Set::value_type, Path>)
    return next->str().starts_with(path + "/");
  else
    return next->starts_with(path + "/");
}

}  // namespace

bool has_archive_prims_at(const LoadState& state, const std::string& path) {
  return has_at_or_below(state.archive_paths, path);
}

bool is_of_model(const LoadState& state, const std::string& path) {
  for (size_t end = path.size(); end != std::string::npos && end > 0; end = path.rfind('/', end - 1))
    if (state.model_names.contains(path.substr(0, end))) return true;
  return false;
}

Path free_path(LoadState* state, const std::string& wanted) {
  std::string path = wanted;
  for (int& copy = state->copies.emplace(wanted, 1).first->second;
       has_archive_prims_at(*state, path) || has_at_or_below(state->model_names, path);)
    path = wanted + std::to_string(++copy);
  return Path(path);
}

bool load_archive(const std::string& file, const ArchiveModel& model, LoadState* state) {
  archive::ReadOptions options = {state->options.allow_outside, model.within};
  options.memory_limit = std::max(state->memory->left(), size_t(1));
  auto read = std::make_unique<host::RetainedSceneDelegate>();
  archive::ReadResult result = archive::ReadArchive(file, read.get(), *state->sink, options);
  if (result.ok && collides(read->GetPrims(), *state)) {
    options.root = free_path(state, "/copy").str();
    read = std::make_unique<host::RetainedSceneDelegate>();
    result = archive::ReadArchive(file, read.get(), {}, options);
  }
  if (result.out_of_memory) state->note_cause(LoadCause::out_of_memory);
  if (!result.ok) return false;
  state->held.resize(state->held.bytes() + result.memory_bytes, file);
  if (model.transform) place_prims(*model.transform, read.get());
  if (!model.motion.values.empty()) move_prims(keys_of(read->GetPrims()), model.motion, read.get());
  drop_loose_limits(file, *state, read.get());
  for (const auto& [path, prim] : read->GetPrims()) {
    if (!std::holds_alternative<RenderSettingsDescription>(prim)) state->scene->Set(path, prim);
    state->archive_paths.insert(path);
  }
  state->result->archives.push_back({file, keys_of(read->GetLights()), keys_of(read->GetMeshes())});
  if (!model.is_first) return true;
  state->has_archive = true;
  take_settings(read->GetAllRenderSettings(), result.info.settings, state);
  state->result->color_config = result.info.color_config.resolved;
  state->result->color_config_within = result.info.color_config.within;
  return true;
}

}  // namespace alabaster::hd::description
