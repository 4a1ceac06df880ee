// Render settings, and values of them, that earlier versions had: errors wherever a host or a file names one.
#pragma once

#include <string>

namespace alabaster::hd::support {

/// One sentence that names the setting, or its value `value`, and what to write instead. Empty if this version has it,
/// or never had it.
std::string RetiredSetting(const std::string& name, const std::string& value);

}  // namespace alabaster::hd::support
