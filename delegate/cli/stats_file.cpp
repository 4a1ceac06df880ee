#include "delegate/cli/stats_file.h"

#include <algorithm>
#include <charconv>
#include <sstream>

#include "delegate/support/process_usage.h"

namespace alabaster::cli {
namespace {

using nlohmann::json;

json dictionary_to_json(const hd::Dictionary& dictionary) {
  json object = json::object();
  for (const auto& [key, value] : dictionary) object[key] = value_to_json(value);
  return object;
}

// The double with the float's shortest decimal: 0.02 stays 0.02 in the file.
double shortest(float value) {
  const std::string text = hd::Value(value).to_string();
  double number = double(value);
  std::from_chars(text.data(), text.data() + text.size(), number);
  return number;
}

double value_number(const hd::Dictionary& dictionary, const std::string& key) {
  const auto found = dictionary.find(key);
  return found == dictionary.end() ? 0 : found->second.number_or(0);
}

json lines_of(const std::string& paragraph) {
  json lines = json::array();
  std::istringstream text(paragraph);
  for (std::string line; std::getline(text, line);)
    if (!line.empty()) lines.push_back(line);
  return lines;
}

}  // namespace

json value_to_json(const hd::Value& value) {
  if (value.empty()) return nullptr;
  if (const auto* held = value.get<std::shared_ptr<const hd::Dictionary>>())
    return *held ? dictionary_to_json(**held) : json();
  if (const auto* number = value.get<float>()) return shortest(*number);
  if (const auto* flag = value.get<bool>()) return *flag;
  if (const auto* number = value.get<double>()) return *number;
  if (const auto* number = value.get<int32_t>()) return *number;
  if (const auto* number = value.get<uint32_t>()) return *number;
  if (const auto* number = value.get<int64_t>()) return *number;
  if (value.get<hd::AssetPath>()) return value.to_string();
  return value.text_or(value.to_string());
}

void RunStats::add_load(double wall, double cpu) {
  load_wall_ += wall;
  load_cpu_ += cpu;
}

void RunStats::add_render(const hd::RenderSettingsDescription& settings, const hd::host::RecordResult& result) {
  stats_.push_back(result.stats);
  resolutions_.push_back({settings.width, settings.height});
  const auto frame = settings.settings.find("frame");
  frames_.push_back(frame == settings.settings.end() ? 0 : uint64_t(frame->second.number_or(0)));
  written_.insert(written_.end(), result.written.begin(), result.written.end());
}

double RunStats::total(const std::string& key) const {
  double sum = 0;
  for (const hd::Dictionary& stats : stats_) sum += value_number(stats, key);
  return sum;
}

json RunStats::to_json(const std::string& scene, const std::string& status, const json& settings) const {
  const auto count = [&](const char* key) { return static_cast<uint64_t>(total(key)); };
  const auto phase = [&](const std::string& name) {
    return json{{"wall", total("phase." + name + ".wall")}, {"cpu", total("phase." + name + ".cpu")}};
  };
  json out;
  out["versions"] = lines_of(AlabasterVersions());
  out["scene"] = scene;
  out["status"] = status;
  if (!stats_.empty())
    if (const auto faults = stats_.front().find("scene.faults"); faults != stats_.front().end())
      out["faults"] = lines_of(faults->second.text_or(""));
  out["settings"] = settings;
  out["resolutions"] = resolutions_;
  out["frames"] = frames_;
  out["files"] = written_;
  out["phases"] = {{"load", {{"wall", load_wall_}, {"cpu", load_cpu_}}},
                   {"refine", {{"wall", total("sync.refineWallSeconds")}, {"cpu", total("sync.refineSeconds")}}},
                   {"build", {{"wall", total("sync.bvhWallSeconds")}, {"cpu", total("sync.bvhSeconds")}}},
                   {"render", phase("render")},
                   {"write", phase("write")}};
  out["rays"] = {{"camera", count("rays.camera")},
                 {"bounce", count("rays.bounce")},
                 {"shadow", count("rays.shadow")},
                 {"walk", count("rays.walk")},
                 {"probe", count("rays.probe")}};
  out["walks"] = {
      {"count", count("walk.count")},   {"segments", count("rays.walk")},
      {"events", count("walk.events")}, {"exits", count("walk.exits")},
      {"lost", count("walk.lost")},     {"lostShare", total("walk.lostEnergy") / std::max(1.0, total("walk.count"))}};
  out["samples"] = {{"perPixel", stats_.empty() ? 0 : value_number(stats_.front(), "numCompletedSamples")},
                    {"total", count("rays.camera")}};
  if (!stats_.empty() && stats_.front().contains("error.relativeRmse"))
    out["error"] = {{"relativeRmse", value_number(stats_.front(), "error.relativeRmse")},
                    {"low95", value_number(stats_.front(), "error.low")},
                    {"high95", value_number(stats_.front(), "error.high")},
                    {"isKnown", stats_.front().at("error.isKnown").get_or(true)}};
  if (!stats_.empty() && stats_.front().contains("target.error")) {
    out["target"] = {{"error", value_number(stats_.front(), "target.error")},
                     {"missed", stats_.front().at("target.missed").get_or(false)},
                     {"endedBy", stats_.front().at("endedBy").text_or("")}};
    for (const char* key : {"samples", "seconds", "cpuSeconds"})
      if (const auto found = stats_.front().find(std::string("target.") + key); found != stats_.front().end())
        out["target"][key] = found->second.number_or(0);
  }
  out["peakMemory"] = hd::support::peak_memory_bytes();
  out["delegate"] = json::array();
  for (const hd::Dictionary& stats : stats_) out["delegate"].push_back(dictionary_to_json(stats));
  return out;
}

}  // namespace alabaster::cli
