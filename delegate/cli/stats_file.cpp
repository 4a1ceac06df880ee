#include "delegate/cli/stats_file.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "delegate/cli/exit_codes.h"
#include "delegate/cli/running_mark.h"
#include "delegate/support/json_values.h"
#include "delegate/support/lookup.h"
#include "delegate/support/process_usage.h"

namespace alabaster::cli {
namespace {

using hd::support::number_in;
using nlohmann::json;

json dictionary_json(const hd::Dictionary& values) {
  return hd::support::json_of(std::make_shared<const hd::Dictionary>(values));
}

json lines_of(const std::string& paragraph) {
  json lines = json::array();
  std::istringstream text(paragraph);
  for (std::string line; std::getline(text, line);)
    if (!line.empty()) lines.push_back(line);
  return lines;
}

/// The samples and the noise of a render: {"samplesPerPixel", "error", "target"}, as far as its statistics have them.
json outcome_of(const hd::Dictionary& stats) {
  json out{{"samplesPerPixel", number_in(stats, "numCompletedSamples")}};
  if (stats.contains("error.relativeRmse"))
    out["error"] = {{"relativeRmse", number_in(stats, "error.relativeRmse")},
                    {"low95", number_in(stats, "error.low")},
                    {"high95", number_in(stats, "error.high")},
                    {"isKnown", stats.at("error.isKnown").get_or(true)}};
  if (!stats.contains("target.error")) return out;
  out["target"] = {{"error", number_in(stats, "target.error")},
                   {"missed", stats.at("target.missed").get_or(false)},
                   {"endedBy", stats.at("endedBy").text_or("")}};
  for (const char* key : {"samples", "seconds", "cpuSeconds"})
    if (const auto found = stats.find(std::string("target.") + key); found != stats.end())
      out["target"][key] = found->second.number_or(0);
  return out;
}

}  // namespace

void RunStats::add_load(double wall, double cpu) {
  load_wall_ += wall;
  load_cpu_ += cpu;
}

void RunStats::add_render(const hd::RenderSettingsDescription& settings, double frame,
                          const hd::host::RecordResult& result) {
  stats_.push_back(result.stats);
  resolutions_.push_back({settings.width, settings.height});
  frames_.push_back(std::nearbyint(frame) == frame ? json(int64_t(frame)) : json(frame));
  written_.insert(written_.end(), result.written.begin(), result.written.end());
}

double RunStats::total(const std::string& key) const {
  double sum = 0;
  for (const hd::Dictionary& stats : stats_) sum += number_in(stats, key.c_str());
  return sum;
}

hd::Dictionary RunStats::noisiest() const {
  const auto error = [](const hd::Dictionary& stats) { return number_in(stats, "error.relativeRmse", -1); };
  const auto found =
      std::max_element(stats_.begin(), stats_.end(), [&](const auto& a, const auto& b) { return error(a) < error(b); });
  return found == stats_.end() ? hd::Dictionary() : *found;
}

json RunStats::to_json(const std::string& scene, int code, const std::string& reason,
                       const hd::Dictionary& settings) const {
  const auto count = [&](const char* key) { return static_cast<uint64_t>(total(key)); };
  const auto phase = [&](const std::string& name) {
    return json{{"wall", total("phase." + name + ".wall")}, {"cpu", total("phase." + name + ".cpu")}};
  };
  json out;
  out["versions"] = lines_of(AlabasterVersions());
  out["scene"] = scene;
  out["status"] = code == kDone          ? "done"
                  : code == kInterrupted ? "interrupted"
                  : code == kDegraded    ? "degraded"
                                         : "failed";
  out["exitCode"] = code;
  if (out["status"] == "failed" && !reason.empty()) out["reason"] = reason;
  out["host"] = host_name();
  const hd::Dictionary first = stats_.empty() ? hd::Dictionary() : stats_.front();
  if (first.contains("scene.faults")) out["faults"] = lines_of(first.at("scene.faults").text_or(""));
  out["settings"] = dictionary_json(settings);
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
  out["renders"] = json::array();
  for (size_t i = 0; i < stats_.size(); ++i) {
    out["renders"].push_back(outcome_of(stats_[i]));
    out["renders"].back().update({{"frame", frames_[i]}, {"resolution", resolutions_[i]}});
  }
  const json worst = outcome_of(noisiest());
  out["samples"] = {{"perPixel", worst["samplesPerPixel"]}, {"total", count("rays.camera")}};
  for (const char* key : {"error", "target"})
    if (worst.contains(key)) out[key] = worst[key];
  out["peakMemory"] = hd::support::peak_memory_bytes();
  out["delegate"] = json::array();
  for (const hd::Dictionary& stats : stats_) out["delegate"].push_back(dictionary_json(stats));
  return out;
}

}  // namespace alabaster::cli
