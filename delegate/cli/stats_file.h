// The --stats file, in JSON. delegate/manual/pipeline.md, "Statistics", has its keys.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "delegate/host/frame_recorder.h"

namespace alabaster::cli {

/// The statistics of one run; renders of several frames or resolutions are added up.
class RunStats {
 public:
  void add_load(double wall, double cpu);  // also of each pose
  void add_render(const hd::RenderSettingsDescription& settings, double frame, const hd::host::RecordResult& result);
  /// `settings`: the effective values of every render setting. `reason`: of a run that failed.
  nlohmann::json to_json(const std::string& scene, int code, const std::string& reason,
                         const hd::Dictionary& settings) const;

  double load_wall() const { return load_wall_; }
  double total(const std::string& key) const;

 private:
  /// The statistics of the render with the greatest error; empty without a render.
  hd::Dictionary noisiest() const;

  double load_wall_ = 0, load_cpu_ = 0;
  std::vector<hd::Dictionary> stats_;
  nlohmann::json resolutions_ = nlohmann::json::array(), frames_ = nlohmann::json::array();
  std::vector<std::string> written_;
};

}  // namespace alabaster::cli
