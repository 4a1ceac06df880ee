#include "delegate/description/quality_presets.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "delegate/support/json_values.h"
#include "delegate/support/presets_text.h"

namespace alabaster::hd::description {

const std::vector<QualityPreset>& QualityPresets() {
  static const std::vector<QualityPreset> presets = [] {
    std::vector<QualityPreset> all;
    const nlohmann::json file = nlohmann::json::parse(support::presets_text());
    for (const nlohmann::json& entry : file.at("presets")) {
      QualityPreset& preset = all.emplace_back(QualityPreset{entry.at("name"), entry.at("description"), {}});
      for (const auto& [name, value] : entry.at("settings").items()) preset.settings[name] = support::value_of(value);
    }
    return all;
  }();
  return presets;
}

const QualityPreset* FindQualityPreset(const std::string& name) {
  const auto& all = QualityPresets();
  const auto found = std::find_if(all.begin(), all.end(), [&](const QualityPreset& p) { return p.name == name; });
  return found == all.end() ? nullptr : &*found;
}

}  // namespace alabaster::hd::description
