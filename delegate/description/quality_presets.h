// Quality presets: names for sets of render settings that were measured to be worth it (schemas/quality_presets.json).
#pragma once

#include <string>
#include <vector>

#include "delegate/api/types.h"

namespace alabaster::hd::description {

struct QualityPreset {
  std::string name;         // "draft"
  std::string description;  // one line
  Dictionary settings;      // by the names of render_settings.json; what is not in it stays as it is
};

/// From the coarsest to the finest. Made once; any thread.
ALABASTER_API const std::vector<QualityPreset>& QualityPresets();

/// Null if no preset is called so.
ALABASTER_API const QualityPreset* FindQualityPreset(const std::string& name);

}  // namespace alabaster::hd::description
