#include "delegate/host/recorded_checkpoints.h"

#include <nlohmann/json.hpp>
#include <utility>

namespace alabaster::hd::host {

void RecordedCheckpoints::report(Severity severity, const std::string& text) const {
  if (options_.diagnostics) options_.diagnostics({severity, kCode, settings_.str(), text});
}

CommandResult RecordedCheckpoints::resume() {
  if (!options_.resume) return {CommandStatus::done, {}, {}};
  CommandResult resumed = delegate_->InvokeCommand("resumeCheckpoint", {{"file", options_.checkpoint}});
  if (!resumed.ok()) report(Severity::error, "checkpoint '" + options_.checkpoint + "': " + resumed.fault);
  return resumed;
}

// The values from which `alabaster merge` writes the files of a render of all samples.
std::string RecordedCheckpoints::note(const RenderSettingsDescription& d) const {
  const Rect2i window = d.window();
  nlohmann::json note = {{"camera", d.camera.str()},
                         {"size", {d.width, d.height}},
                         {"window", {window.minX, window.minY, window.maxX, window.maxY}},
                         {"pixelAspectRatio", d.pixelAspectRatio},
                         {"frame", d.frame},
                         {"degraded", delegate_->GetRenderStats().contains("scene.faults")}};
  for (const RenderSettingDescriptor& setting : delegate_->GetRenderSettingDescriptors()) {
    const Value value = delegate_->GetRenderSetting(setting.key);
    nlohmann::json& noted = note["settings"][setting.key.str()];
    if (const bool* held = value.get<bool>())
      noted = *held;
    else if (const float* held = value.get<float>())
      noted = *held;
    else if (const std::string text = value.text_or(""); !text.empty())
      noted = text;
    else
      noted = static_cast<int64_t>(value.number_or(0));
  }
  return note.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string RecordedCheckpoints::write(const RenderSettingsDescription& settings) {
  const auto begun = std::chrono::steady_clock::now();
  const Dictionary arguments{{"file", options_.checkpoint}, {"note", note(settings)}};
  const CommandResult written = delegate_->InvokeCommand("writeCheckpoint", arguments);
  saved_ = std::chrono::steady_clock::now();
  seconds_ += std::chrono::duration<double>(saved_ - begun).count();
  ++count_;
  if (written.ok()) return {};
  return "checkpoint '" + options_.checkpoint + "' could not be written: " + written.fault;
}

void RecordedCheckpoints::write_if_due(const RenderSettingsDescription& settings) {
  const std::chrono::duration<double> since = std::chrono::steady_clock::now() - saved_;
  if (options_.checkpoint.empty() || since.count() < options_.checkpoint_seconds) return;
  const std::string fault = write(settings);
  if (!fault.empty() && !std::exchange(warned_, true)) report(Severity::warning, fault + ". The render goes on");
}

void RecordedCheckpoints::write_last(const RenderSettingsDescription& settings) {
  if (options_.checkpoint.empty()) return;
  last_fault_ = write(settings);
  if (!last_fault_.empty()) report(Severity::error, last_fault_);
}

void RecordedCheckpoints::add_to(Dictionary* stats) const {
  if (options_.checkpoint.empty()) return;
  (*stats)["checkpoint.count"] = count_;
  (*stats)["phase.checkpoint.wall"] = seconds_;
}

}  // namespace alabaster::hd::host
