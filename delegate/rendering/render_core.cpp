#include "delegate/rendering/render_core.h"

#include <algorithm>
#include <chrono>

#include "delegate/rendering/render_pass.h"

namespace alabaster::hd::rendering {
namespace {

const SettingParameter* find_setting(const Token& key) {
  const auto table = setting_parameters();
  const auto found = std::find_if(table.begin(), table.end(), [&](const auto& p) { return key.str() == p.name; });
  return found == table.end() ? nullptr : &*found;
}

}  // namespace

RenderCore::RenderCore(std::shared_ptr<prims::SceneParam> scene_param, const Dictionary& initial_settings)
    : param(std::move(scene_param)), translator_(param->sink()), compiler_(param->device(), param->sink()) {
  for (const auto& [key, value] : initial_settings) set_setting(key, value);
}

void RenderCore::set_setting(const Token& key, const Value& value) {
  {
    const std::lock_guard lock(mutex_);
    const auto held = settings_.find(key);
    if (held == settings_.end() ? value.empty() : held->second == value) return;
    if (value.empty())
      settings_.erase(held);
    else
      settings_[key] = value;
    ++settings_version_;
  }
  const SettingParameter* parameter = find_setting(key);
  RenderSettings unused;
  if (parameter && !value.empty())
    prims::report_fault(param->sink(), "render settings", key.str(), prims::set_parameter(*parameter, value, &unused),
                        value);
  if (key == Token("textureMemory")) param->set_texture_memory(render_settings().texture_memory, true);
  if (key == Token("refineEdgeLength")) {
    param->set_dices(render_settings().refine_edge_length > 0);
    dicing_changed_ = true;
  }
  if (key == Token("threads")) param->set_threads(render_settings().threads);
}

Value RenderCore::setting(const Token& key) const {
  {
    const std::lock_guard lock(mutex_);
    const auto held = settings_.find(key);
    if (held != settings_.end()) return held->second;
  }
  const SettingParameter* parameter = find_setting(key);
  return parameter ? prims::get_parameter(*parameter, render_settings()) : Value();
}

uint32_t RenderCore::settings_version() const {
  const std::lock_guard lock(mutex_);
  return settings_version_;
}

// The prim that setting "renderSettingsPrimPath" names, else the first by path.
const prims::SettingsRecord* RenderCore::settings_prim() const {
  Path named;
  {
    const std::lock_guard lock(mutex_);
    const auto held = settings_.find("renderSettingsPrimPath");
    if (held != settings_.end()) named = Path(held->second.text_or(""));
  }
  if (!named.empty()) {
    const auto found = records_.find(named);
    return found == records_.end() ? nullptr : std::get_if<prims::SettingsRecord>(&found->second);
  }
  for (const auto& [path, record] : records_)
    if (const auto* settings = std::get_if<prims::SettingsRecord>(&record)) return settings;
  return nullptr;
}

RenderSettings RenderCore::render_settings() const {
  RenderSettings out;
  const prims::SettingsRecord* prim = settings_prim();
  const std::lock_guard lock(mutex_);
  for (const SettingParameter& parameter : setting_parameters()) {
    if (prim) {
      if (Token("frame") == Token(parameter.name)) prims::set_parameter(parameter, prim->settings.frame, &out);
      const auto value = prim->settings.settings.find(parameter.name);
      if (value != prim->settings.settings.end()) prims::set_parameter(parameter, value->second, &out);
    }
    const auto value = settings_.find(parameter.name);
    if (value != settings_.end()) prims::set_parameter(parameter, value->second, &out);
  }
  return out;
}

Path RenderCore::settings_camera() const {
  const prims::SettingsRecord* prim = settings_prim();
  return prim ? prim->settings.camera : Path();
}

std::optional<CameraParameters> RenderCore::camera(const Path& path) const {
  const auto found = records_.find(path);
  const auto* record = found == records_.end() ? nullptr : std::get_if<prims::CameraRecord>(&found->second);
  if (!record) return std::nullopt;
  return prims::posed_camera(*record, translation_.shutter);
}

std::shared_ptr<const Denoiser> RenderCore::denoiser(std::string* problem) {
  if (!denoiser_ && denoiser_problem_.empty()) denoiser_ = Denoiser::load(&denoiser_problem_);
  *problem = denoiser_problem_;
  return denoiser_;
}

// Memory may run out at any step: an edit leaves the list once it is applied whole.
void RenderCore::apply_edits() {
  edits_.splice(edits_.end(), param->take_edits());
  for (; !edits_.empty(); edits_.pop_front()) {
    prims::Edit& edit = edits_.front();
    prims::Record& held = records_[edit.id];
    stale_ |= (prims::is_drawn(held) || prims::is_drawn(edit.record)) && held != edit.record;
    held = std::move(edit.record);
    if (std::holds_alternative<std::monostate>(held)) records_.erase(edit.id);
  }
}

void RenderCore::publish() {
  std::shared_ptr<const SceneSnapshot> compiled;
  prims::guarded(param->sink(), "CommitResources",
                 [&] { param->run([&] { compiled = compiler_.compile(translation_.scene, ++scene_number_); }); });
  if (!compiled) compiler_.forget();
  stale_ = !compiled;
  last_request_.reset();  // it holds the old snapshot
  {
    const std::lock_guard lock(mutex_);
    snapshot_ = compiled;
  }
  for (const auto& pass : passes()) pass->cancel_stale(compiled.get());
}

// Measured from the camera of the RenderSettings prim, in its picture.
prims::Dicing RenderCore::dicing() const {
  prims::Dicing out;
  out.edge_length = render_settings().refine_edge_length;
  if (out.edge_length == 0) return {};
  const prims::SettingsRecord* const prim = settings_prim();
  const std::optional<CameraParameters> seen_by = camera(settings_camera());
  if (!prim || !seen_by) {
    alabaster::report(param->sink(), alabaster::Severity::warning, "settings.refineEdgeLength", "render settings",
                      "refineEdgeLength needs a RenderSettings prim with a camera; refineLevel is used");
    return {};
  }
  out.camera = *seen_by;
  out.width = prim->settings.width, out.height = prim->settings.height;
  return out;
}

void RenderCore::update_scene() {
  apply_edits();
  param->set_threads(render_settings().threads);
  dicing_changed_ = false;
  if (const prims::Dicing now = dicing(); now != dicing_) {
    dicing_ = now;
    stale_ = true;
  }
  const Shutter shutter = prims::shutter_of(records_);
  if (!stale_ && shutter == translation_.shutter) return;
  const prims::Records& built = deferred_.build(records_, dicing_, *param);
  prims::Translation translation = translator_.translate(built, shutter, deformations_.in(shutter, built, param.get()));
  const bool same = snapshot() && translation.scene == translation_.scene;
  translation_ = std::move(translation);
  if (same)
    stale_ = false;
  else
    publish();
}

void RenderCore::commit() {
  const auto start = std::chrono::steady_clock::now();
  if (!needs_commit() && edits_.empty() && !stale_) return;
  committed_ = true;
  const bool updated = prims::guarded(param->sink(), "CommitResources", [&] { update_scene(); });
  param->set_failed(&commit_failed_, !updated);
  failed_ = !snapshot();
  const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start;
  commit_seconds_ = commit_seconds_ + spent.count();
}

std::string RenderCore::dump() const {
  return prims::dump_scene(translation_, records_);
}

std::string RenderCore::requirements() const {
  const auto held = snapshot();
  return held ? prims::describe_requirements(*held, translation_) : std::string();
}

std::shared_ptr<const SceneSnapshot> RenderCore::snapshot() const {
  const std::lock_guard lock(mutex_);
  return snapshot_;
}

std::vector<std::string> RenderCore::scene_faults(bool* input) const {
  std::vector<std::string> texts;
  *input = true;
  for (const auto& [prim, fault] : param->faults()) {
    texts.push_back(prim.str() + ": " + fault.text);
    *input = *input && fault.input;
  }
  if (const int failed = param->failed(); failed > 0) {
    texts.push_back(std::to_string(failed) + " prims or commits failed, for want of memory or by the host's scene");
    *input = false;
  }
  if (const auto held = snapshot()) {
    for (const std::string& name : held->left_out) texts.push_back(name + ": could not be placed");
    texts.insert(texts.end(), held->faults.begin(), held->faults.end());
  }
  return texts;
}

std::string RenderCore::commit_error() const {
  return failed_ ? "the scene could not be compiled" : "";
}

void RenderCore::add_pass(const std::shared_ptr<PassControl>& pass) {
  const std::lock_guard lock(mutex_);
  std::erase_if(passes_, [](const auto& weak) { return weak.expired(); });
  passes_.push_back(pass);
}

std::vector<std::shared_ptr<PassControl>> RenderCore::passes() const {
  std::vector<std::shared_ptr<PassControl>> alive;
  const std::lock_guard lock(mutex_);
  for (const auto& weak : passes_)
    if (auto pass = weak.lock()) alive.push_back(std::move(pass));
  return alive;
}

// Halts the passes, or has them start again once nothing stops them.
void RenderCore::apply_stops() {
  stopped_ = stop_latched_ || stop_holds_ > 0;
  param->set_cancelled(stopped_);
  if (!stopped_) ++restarts_;
  for (const auto& pass : passes()) stopped_ ? pass->halt() : pass->forget();
}

void RenderCore::stop() {
  const std::lock_guard lock(stop_mutex_);
  stop_latched_ = true;
  apply_stops();
}

void RenderCore::restart() {
  const std::lock_guard lock(stop_mutex_);
  stop_latched_ = false;
  apply_stops();
}

void RenderCore::hold_stopped(int change) {
  const std::lock_guard lock(stop_mutex_);
  stop_holds_ += change;
  apply_stops();
}

void RenderCore::pause() {
  paused_ = true;
  for (const auto& pass : passes()) pass->pause();
}

void RenderCore::resume() {
  paused_ = false;
  for (const auto& pass : passes()) pass->resume();
}

}  // namespace alabaster::hd::rendering
