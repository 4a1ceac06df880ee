// The files and variables outside of a colour configuration on which its transforms depend.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "core/color/color_config.h"

namespace alabaster {

struct ConfigInputs {
  std::string library;  // the version of OpenColorIO that this process has loaded
  /// The LUTs that its transforms name, by their names in the configuration: where each is found by the search path,
  /// empty where it is not.
  std::map<std::string, std::string> luts;
  /// The variables of the environment that its text names, with their values or defaults, and OpenColorIO's own that
  /// choose displays, views and spaces. Empty: not set.
  std::map<std::string, std::optional<std::string>> variables;
};

/// `config`: from ColorConfig::load(). Any thread.
ConfigInputs config_inputs(const ColorConfig& config);

/// Warns, once for the object, of a configuration that has no way to CIE XYZ, where chromaticities are to be written.
void report_unknown_primaries(const ColorConfig& config, const DiagnosticSink& sink);

}  // namespace alabaster
