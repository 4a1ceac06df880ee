#include "delegate/host/recorded_checkpoints.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "delegate/host/input_digests.h"
#include "delegate/host/product_metadata.h"
#include "delegate/host/scene_fields.h"
#include "delegate/support/json_values.h"

namespace alabaster::hd::host {
namespace {

using Numbers = std::vector<double>;
Numbers numbers_of(const Value& matrix) {
  Numbers numbers;
  for (size_t i = 0; i < 16; ++i) numbers.push_back(matrix.component(i));
  return numbers;
}
std::optional<Matrix4d> matrix_of(const Numbers& numbers) {
  Matrix4d matrix;
  if (numbers.size() != 16) return std::nullopt;
  std::copy(numbers.begin(), numbers.end(), matrix.getValue());
  return matrix;
}

}  // namespace

void RecordedCheckpoints::report(Severity severity, const std::string& text) const {
  if (options_.diagnostics) options_.diagnostics({severity, kCode, settings_.str(), text});
}

CommandResult RecordedCheckpoints::resume() {
  if (!options_.resume) return {CommandStatus::done, {}, {}};
  CommandResult resumed = delegate_->InvokeCommand("resumeCheckpoint", {{"file", options_.checkpoint}});
  if (!resumed.ok()) report(Severity::error, "checkpoint '" + options_.checkpoint + "': " + resumed.fault);
  return resumed;
}

std::string RecordedCheckpoints::note(const RenderSettingsDescription& d) const {
  RenderSettingsDescription frame = d;
  frame.products.clear();
  for (const RenderProduct& product : d.products.empty() ? options_.of_frame : d.products)
    if (product.camera.empty() && product.width == 0) {
      RenderProduct& shown = frame.products.emplace_back();
      shown.file = product.file, shown.dataType = product.dataType, shown.colorSpace = product.colorSpace;
      shown.display = product.display, shown.view = product.view, shown.look = product.look;
      shown.exposure = product.exposure, shown.compression = product.compression;
      shown.tiles = product.tiles;
    }
  frame.settings.clear();
  const Dictionary stats = delegate_->GetRenderStats();
  nlohmann::json note = {{"degraded", stats.contains("scene.faults")},
                         {"fields", nlohmann::json::object()},
                         {"settings", nlohmann::json::object()}};
  if (!colors_.is_null()) note["colors"] = colors_;
  for (const auto& [name, value] : GetFields({}, frame)) note["fields"][name] = support::json_of(value);
  for (const RenderSettingDescriptor& setting : delegate_->GetRenderSettingDescriptors())
    note["settings"][setting.key.str()] = support::json_of(delegate_->GetRenderSetting(setting.key));
  for (const char* name : kCameraMatrices)
    if (const auto found = stats.find(std::string("camera.") + name); found != stats.end())
      note["camera"][name] = numbers_of(found->second);
  return note.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::optional<FrameNote> ReadFrameNote(const std::string& text) {
  try {
    const nlohmann::json note = nlohmann::json::parse(text);
    Fields fields;
    for (const auto& [name, value] : note.at("fields").items()) fields.emplace_back(name, support::value_of(value));
    FrameNote read;
    read.degraded = note.at("degraded").get<bool>();
    if (!ReadSettings(fields, &read.frame).empty()) return std::nullopt;
    if (const auto colors = note.find("colors"); colors != note.end())
      read.color_config = colors->at("config").get<std::string>(), read.color_digest = colors->at("digest");
    for (const auto& [name, value] : note.at("settings").items()) read.frame.settings[name] = support::value_of(value);
    if (const auto camera = note.find("camera"); camera != note.end())
      for (const char* name : kCameraMatrices)
        if (const auto matrix = matrix_of(camera->value(name, Numbers()))) read.metadata[name] = *matrix;
    for (const char* limit : {"memoryLimit", "textureMemory", "threads"}) read.frame.settings.erase(limit);
    return read;
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;
  }
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

void RecordedCheckpoints::begin() {
  saved_ = std::chrono::steady_clock::now();
  if (options_.checkpoint.empty()) return;
  const auto colors = ReadColorInputs(options_.colors, options_.diagnostics);
  if (!colors) return;
  const bool is_file = colors->origin != "built-in" && colors->origin.find("://") == std::string::npos;
  colors_ = {
      {"config", is_file ? std::filesystem::absolute(colors->origin).lexically_normal().string() : colors->origin},
      {"digest", colors->all()}};
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
