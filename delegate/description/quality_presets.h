// Quality presets: named sets of measured render settings (schemas/quality_presets.json).
#pragma once

#include <string>
#include <vector>

#include "delegate/api/types.h"

namespace alabaster::hd::description {

struct QualityPreset {
  std::string name;         // "draft"
  std::string description;  // one line
  Dictionary settings;      // by the names of render_settings.json; settings not in it are left alone
};

/// All presets, from the coarsest to the finest. Any thread.
ALABASTER_API const std::vector<QualityPreset>& QualityPresets();

/// The preset of that name; null if there is none.
ALABASTER_API const QualityPreset* FindQualityPreset(const std::string& name);

}  // namespace alabaster::hd::description
