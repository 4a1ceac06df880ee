// The --stats file: what a render cost, as JSON.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "delegate/host/frame_recorder.h"

namespace alabaster::cli {

/// What one run did; renders of several resolutions are added up.
class RunStats {
 public:
  void set_load(double wall, double cpu);
  void add_render(const hd::RenderSettingsDescription& settings, const hd::host::RecordResult& result);
  /// `settings`: the effective values of every render setting.
  nlohmann::json to_json(const std::string& scene, const std::string& status, const nlohmann::json& settings) const;

  double load_wall() const { return load_wall_; }
  double total(const std::string& key) const;

 private:
  double load_wall_ = 0, load_cpu_ = 0;
  std::vector<hd::Dictionary> stats_;
  nlohmann::json resolutions_ = nlohmann::json::array();
  std::vector<std::string> written_;
};

nlohmann::json value_to_json(const hd::Value& value);

/// Writes under a temporary name in the same folder and renames. False: *error says why.
bool write_text_file(const std::string& file, const std::string& text, std::string* error);

}  // namespace alabaster::cli
