// The schemas that are written by hand travel inside the library, so that it needs no data files.
#pragma once

#include <string>

namespace alabaster::hd::support {

/// The text of schemas/<name>.json; null if it is none of these: textures, render_description, quality_presets.
const char* schema_text(const std::string& name);

}  // namespace alabaster::hd::support
