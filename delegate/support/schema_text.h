// The schemas travel inside the library, so that it needs no data files.
#pragma once

#include <string>

namespace alabaster::hd::support {

/// The text of schemas/<name>.json; null if there is none.
const char* schema_text(const std::string& name);

}  // namespace alabaster::hd::support
