// The --stats file, in JSON:
// - versions [text]: of Alabaster and what it is built on
// - scene text: as given
// - status: "done", "degraded" (rendered by --keep-going without all that the scene names), "interrupted" or "failed"
// - faults [text]: parts of the scene that the picture lacks; absent if none
// - settings {name: value}: every render setting as it was in effect
// - resolutions [[width, height]], frames [number]: of each render
// - files [text]: that were written
// - phases {load, refine, build, render, write: {wall, cpu}}: seconds; cpu of all threads together
// - rays {camera, bounce, shadow, walk, probe}
// - walks {count, segments, events, exits, lost, lostShare}: lostShare is the energy lost in open meshes, of what
// entered
// - samples {perPixel, total}
// - error {relativeRmse, low95, high95, isKnown}: noise as the render estimates it in itself; absent below two samples.
//   isKnown is false where few samples found much light: then the error is at least low95, and the rest is a guess
// - target {error, missed, endedBy}: of a render with targetError that is over. missed: it is, or the doubt about the
//   error allows it; then samples (per pixel), seconds and cpuSeconds tell what the target would take in all
// - peakMemory: bytes of the process
// - delegate [{name: value}]: RenderDelegate::GetRenderStats of each render, and the recorder's phases
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "delegate/host/frame_recorder.h"

namespace alabaster::cli {

/// The statistics of one run; renders of several frames or resolutions are added up.
class RunStats {
 public:
  void add_load(double wall, double cpu);  // also of each pose
  void add_render(const hd::RenderSettingsDescription& settings, const hd::host::RecordResult& result);
  /// `settings`: the effective values of every render setting.
  nlohmann::json to_json(const std::string& scene, const std::string& status, const nlohmann::json& settings) const;

  double load_wall() const { return load_wall_; }
  double total(const std::string& key) const;

 private:
  double load_wall_ = 0, load_cpu_ = 0;
  std::vector<hd::Dictionary> stats_;
  nlohmann::json resolutions_ = nlohmann::json::array(), frames_ = nlohmann::json::array();
  std::vector<std::string> written_;
};

nlohmann::json value_to_json(const hd::Value& value);

}  // namespace alabaster::cli
