// The presets of quality travel inside the library, so that it needs no data files.
#pragma once

namespace alabaster::hd::support {

/// The text of schemas/quality_presets.json.
const char* presets_text();

}  // namespace alabaster::hd::support
