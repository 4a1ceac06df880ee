#include "delegate/rendering/render_core.h"

#include <algorithm>
#include <chrono>

#include "delegate/rendering/render_pass.h"

namespace alabaster::hd::sync {
namespace {

const SettingParameter* find_setting(const Token& key) {
  const auto table = setting_parameters();
  const auto found = std::find_if(table.begin(), table.end(), [&](const auto& p) { return key.str() == p.name; });
  return found == table.end() ? nullptr : &*found;
}

}  // namespace

RenderCore::RenderCore(std::shared_ptr<SceneParam> scene_param, const Dictionary& initial_settings)
    : param(std::move(scene_param)), translator_(param->sink()) {
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
    report_fault(param->sink(), "render settings", key.str(), set_parameter(*parameter, value, &unused), value);
  if (key == Token("threads")) param->set_threads(render_settings().threads);
}

Value RenderCore::setting(const Token& key) const {
  {
    const std::lock_guard lock(mutex_);
    const auto held = settings_.find(key);
    if (held != settings_.end()) return held->second;
  }
  const SettingParameter* parameter = find_setting(key);
  return parameter ? get_parameter(*parameter, render_settings()) : Value();
}

uint32_t RenderCore::settings_version() const {
  const std::lock_guard lock(mutex_);
  return settings_version_;
}

// The prim that setting "renderSettingsPrimPath" names, else the first by path.
const SettingsRecord* RenderCore::settings_prim() const {
  Path named;
  {
    const std::lock_guard lock(mutex_);
    const auto held = settings_.find("renderSettingsPrimPath");
    if (held != settings_.end()) named = Path(held->second.text_or(""));
  }
  if (!named.empty()) {
    const auto found = records_.find(named);
    return found == records_.end() ? nullptr : std::get_if<SettingsRecord>(&found->second);
  }
  for (const auto& [path, record] : records_)
    if (const auto* settings = std::get_if<SettingsRecord>(&record)) return settings;
  return nullptr;
}

RenderSettings RenderCore::render_settings() const {
  RenderSettings out;
  const SettingsRecord* prim = settings_prim();
  const std::lock_guard lock(mutex_);
  for (const SettingParameter& parameter : setting_parameters()) {
    if (prim) {
      if (Token("frame") == Token(parameter.name)) set_parameter(parameter, prim->settings.frame, &out);
      const auto value = prim->settings.settings.find(parameter.name);
      if (value != prim->settings.settings.end()) set_parameter(parameter, value->second, &out);
    }
    const auto value = settings_.find(parameter.name);
    if (value != settings_.end()) set_parameter(parameter, value->second, &out);
  }
  return out;
}

Path RenderCore::settings_camera() const {
  const SettingsRecord* prim = settings_prim();
  return prim ? prim->settings.camera : Path();
}

const CameraParameters* RenderCore::camera(const Path& path) const {
  const auto found = records_.find(path);
  const auto* record = found == records_.end() ? nullptr : std::get_if<CameraRecord>(&found->second);
  return record ? &record->camera : nullptr;
}

// Whether anything that is drawn changed.
bool RenderCore::apply_edits() {
  bool changed = false;
  for (Edit& edit : param->take_edits()) {
    const auto held = records_.find(edit.id);
    const bool gone = std::holds_alternative<std::monostate>(edit.record);
    if (held == records_.end()) {
      if (gone) continue;
      changed |= is_drawn(edit.record);
      records_.emplace(edit.id, std::move(edit.record));
      continue;
    }
    changed |= (is_drawn(held->second) || is_drawn(edit.record)) && held->second != edit.record;
    if (gone)
      records_.erase(held);
    else
      held->second = std::move(edit.record);
  }
  return changed;
}

void RenderCore::publish() {
  std::shared_ptr<const SceneSnapshot> compiled;
  std::string error;
  param->run([&] { compiled = compile_snapshot(translation_.scene, ++scene_number_, param->device(), param->sink()); });
  if (!compiled) error = "the scene could not be compiled";
  {
    const std::lock_guard lock(mutex_);
    snapshot_ = compiled;
    error_ = error;
  }
  for (const auto& pass : passes()) pass->cancel_stale(compiled.get());
}

void RenderCore::commit() {
  const auto start = std::chrono::steady_clock::now();
  const bool first = !committed_;
  const bool edited = param->has_edits();
  if (edited || first) {
    committed_ = true;
    if (apply_edits() || first) {
      Translation translation = translator_.translate(records_);
      if (first || translation.scene != translation_.scene) {
        translation_ = std::move(translation);
        publish();
      }
    }
    param->set_threads(render_settings().threads);
  }
  const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start;
  commit_seconds_ = commit_seconds_ + spent.count();
}

std::string RenderCore::dump() const {
  return dump_scene(translation_, records_);
}

std::string RenderCore::requirements() const {
  const auto held = snapshot();
  return held ? describe_requirements(*held, translation_) : std::string();
}

std::shared_ptr<const SceneSnapshot> RenderCore::snapshot() const {
  const std::lock_guard lock(mutex_);
  return snapshot_;
}

std::string RenderCore::commit_error() const {
  const std::lock_guard lock(mutex_);
  return error_;
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

void RenderCore::stop() {
  stopped_ = true;
  param->set_cancelled(true);
  for (const auto& pass : passes()) pass->halt();
}

void RenderCore::restart() {
  stopped_ = false;
  param->set_cancelled(false);
  ++restarts_;
  for (const auto& pass : passes()) pass->forget();
}

void RenderCore::pause() {
  paused_ = true;
  for (const auto& pass : passes()) pass->pause();
}

void RenderCore::resume() {
  paused_ = false;
  for (const auto& pass : passes()) pass->resume();
}

}  // namespace alabaster::hd::sync
