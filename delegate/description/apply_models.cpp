#include <algorithm>
#include <memory>

#include "delegate/description/lengths.h"
#include "delegate/description/load_state.h"
#include "delegate/description/places.h"
#include "delegate/support/extension.h"
#include "delegate/support/lookup.h"
#include "delegate/usd/usd_source.h"

namespace alabaster::hd::description {
namespace {

using host::SourceFault;

// Paths -------------------------------------------------------------------------------------------

// True if that path, or one below it, is among them.
bool has_at_or_below(const std::set<Path>& paths, const std::string& path) {
  const auto next = paths.lower_bound(Path(path + "/"));
  return paths.contains(Path(path)) || (next != paths.end() && next->str().starts_with(path + "/"));
}

// What comes before the paths of a model that would meet those of another.
std::string free_root(const host::SceneFacts& facts, const host::Prims& prims, LoadState* state) {
  if (facts.root.empty()) {
    const bool meets = std::any_of(prims.begin(), prims.end(), [&](const auto& prim) {
      return state->archive_paths.contains(prim.first) || is_of_model(*state, prim.first.str());
    });
    return meets ? free_path(state, "/copy").str() : std::string();
  }
  std::string root;
  for (int& copy = state->copies.emplace(facts.root.str(), 1).first->second;
       has_at_or_below(state->archive_paths, root + facts.root.str()) ||
       !state->model_names.insert(Path(root + facts.root.str())).second;)
    root = "/copy" + std::to_string(++copy);
  return root;
}

// Render settings of a model ----------------------------------------------------------------------

// A file may lower the limit of memory, and not raise it.
void drop_loose_limits(const std::string& file, const LoadState& state, host::Prims* prims) {
  for (auto& [path, prim] : *prims) {
    auto* settings = std::get_if<RenderSettingsDescription>(&prim);
    if (!settings) continue;
    const auto limit = settings->settings.find("memoryLimit");
    if (limit == settings->settings.end() || !loosens_memory_limit(limit->second.number_or(0))) continue;
    if (limit->second.number_or(0) != 0)
      state.report(Severity::warning, "archive.memoryLimit", file + ": " + path.str(),
                   refused_limit_text(state.options));
    settings->settings.erase(limit);
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
void take_settings(const host::Prims& prims, const Path& chosen, LoadState* state) {
  const host::PrimsOf<RenderSettingsDescription> all(prims);
  if (all.empty()) return;
  const auto first = all.contains(chosen) ? all.find(chosen) : all.begin();
  state->settings_path = first->first, state->archive_settings = true;
  state->settings = first->second;
  state->settings.products.clear();
  const Path& camera = first->second.camera;
  if (host::FindPrim<CameraDescription>(prims, camera))
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

// Models ------------------------------------------------------------------------------------------

// The shutter of the description, over which animations are sampled.
FrameShutter shutter_of(const LoadState& load) {
  const nlohmann::json* camera = load.part("camera");
  return {camera ? camera->value("shutterOpen", 0.0) : 0, camera ? camera->value("shutterClose", 0.0) : 0};
}

// A product has AOV motion.
bool shows_motion(const LoadState& load) {
  const nlohmann::json* const products = load.part("products");
  return products && std::any_of(products->begin(), products->end(), [](const nlohmann::json& product) {
           const auto aovs = product.find("aovs");
           return aovs != product.end() && std::count(aovs->begin(), aovs->end(), "motion") > 0;
         });
}

// Opens a model, and has it say its prims.
SourceFault read_model(LoadState& load, const nlohmann::json& entry, const AssetPath& file, OpenModel* model,
                       host::SceneEdits* edits) {
  host::SourceOptions options;
  options.allow_outside = load.options.allow_outside;
  options.within = file.within;
  options.memory_limit = std::max(load.memory->left(), size_t(1));
  options.scene = entry.value("scene", "");
  options.animation = entry.value("animation", "");
  options.variant = entry.value("variant", "");
  options.refine_level = entry.value("refineLevel", options.refine_level);
  model->shutter = shutter_of(load);
  const std::optional<bool>& next_frame = load.options.next_frame;
  model->next_frame = next_frame ? *next_frame : shows_motion(load);
  // A stage's reader samples the shutter itself, that of its camera, too.
  options.stage = load.options.stage;
  if (usd::is_stage(support::lower_extension(file.resolved))) {
    if (model->shutter.close > model->shutter.open) options.stage.shutter = {model->shutter.open, model->shutter.close};
    if (next_frame || model->next_frame) options.stage.next_frame = std::exchange(model->next_frame, false);
    model->shutter = {};
    if (const nlohmann::json* camera = load.part("camera"); camera && camera->contains("use"))
      options.stage.camera = camera->value("use", "");
  }
  options.keep_going = load.options.keep_going;
  if (load.options.complexity) options.refine_level = *load.options.complexity;
  model->frames_per_second = load.options.frames_per_second;
  if (entry.contains("time")) model->own_time = entry["time"].get<double>();
  model->memory = load.memory;
  options.is_timed =
      model->own_time || load.options.time || load.options.frame || model->shutter.close > model->shutter.open;
  const SourceFault fault = model->source->Open(file.resolved, options, *load.sink);
  return fault == SourceFault::none ? model->pose(model->time_of(load.options), *load.sink, edits) : fault;
}

// Replaces lengths with a unit by numbers of scene units.
void resolve(double metres_per_unit, const std::string& pointer, LoadState& load) {
  if (!resolve_lengths(metres_per_unit, description_key(), &load.document.value))
    load.fail(pointer,
              "A length is too large in the scene's unit, of " + nlohmann::json(metres_per_unit).dump() + " metres.");
}

// False after the report of a fault of the file, whose cause is noted.
bool add_model(LoadState& load, const std::string& pointer, const nlohmann::json& entry) {
  const AssetPath file = load.asset(pointer + "/file", entry["file"]);
  auto model = std::make_unique<OpenModel>();
  model->source = source_of(file.resolved);
  if (!model->source)
    load.fail(pointer + "/file", "'" + file.resolved +
                                     "' is not a model: name a file that ends in .gltf, .glb, .usd, .usda, .usdc, "
                                     ".usdz or .alab.");
  if (support::lower_extension(file.resolved) == ".alab")
    for (const char* key : {"scene", "animation", "variant", "time", "refineLevel"})
      if (entry.contains(key))
        load.fail(pointer_append(pointer, key),
                  "An archive has one scene, at one time, with its own levels of refinement: leave it out.");
  host::SceneEdits edits;
  const SourceFault fault = read_model(load, entry, file, model.get(), &edits);
  const LoadOptions& asked = load.options;
  if (fault == SourceFault::choice && !(asked.scene + asked.animation + asked.variant).empty())
    load.note_cause(LoadCause::option);
  else if (fault != SourceFault::none)
    load.note_cause(fault == SourceFault::out_of_memory ? LoadCause::out_of_memory : LoadCause::input);
  if (fault != SourceFault::none) return false;

  const host::SceneFacts& facts = model->source->Facts();
  if (pointer.ends_with("/0")) resolve(facts.metersPerUnit, pointer, load);
  model->placement = placement_of(load, pointer, entry);
  load.held.resize(load.held.bytes() + facts.memory_bytes, file.resolved);
  model->root = free_root(facts, edits.prims, &load);
  model->place(&edits);
  drop_loose_limits(file.resolved, load, &edits.prims);
  if (facts.root.empty())
    for (const auto& [path, prim] : edits.prims) load.archive_paths.insert(path);
  load.result->models.push_back({facts, support::keys_of(host::PrimsOf<host::MeshDescription>(edits.prims)),
                                 support::keys_of(host::PrimsOf<host::LightDescription>(edits.prims)),
                                 support::keys_of(host::PrimsOf<CameraDescription>(edits.prims))});
  if (pointer.ends_with("/0")) {
    load.result->info = facts;
    load.is_complete = facts.is_complete;
    take_settings(edits.prims, Path(model->root + facts.settings.str()), &load);
    load.result->color_config = facts.color_config.resolved;
    load.result->color_config_within = facts.color_config.within;
  }
  std::erase_if(edits.prims,
                [](const auto& prim) { return std::holds_alternative<RenderSettingsDescription>(prim.second); });
  if (model->apply(std::move(edits), *load.sink, load.scene) != SourceFault::none) throw LoadFailed();
  model->shown();
  load.models.push_back(std::move(model));
  return true;
}

}  // namespace

bool is_of_model(const LoadState& state, const std::string& path) {
  for (size_t end = path.size(); end != std::string::npos && end > 0; end = path.rfind('/', end - 1))
    if (state.model_names.contains(Path(path.substr(0, end)))) return true;
  return false;
}

Path free_path(LoadState* state, const std::string& wanted) {
  std::string path = wanted;
  for (int& copy = state->copies.emplace(wanted, 1).first->second;
       has_at_or_below(state->archive_paths, path) || has_at_or_below(state->model_names, path);)
    path = wanted + std::to_string(++copy);
  return Path(path);
}

void apply_models(LoadState& load) {
  const char* const list = load.part("models") ? "models" : "gltf";
  if (load.part("models") && load.part("gltf"))
    load.fail("/gltf", "It is the former name of 'models': put all models into that list.");
  bool ok = true;
  load.for_each_entry(list, [&](const std::string& pointer, const nlohmann::json& model) {
    ok = add_model(load, pointer, model) && ok;
    if (!ok && pointer.ends_with("/0")) resolve(1, pointer, load);  // for the faults of the others
  });
  if (!ok) throw LoadFailed();
  if (load.models.empty()) resolve(1, "", load);
}

}  // namespace alabaster::hd::description
