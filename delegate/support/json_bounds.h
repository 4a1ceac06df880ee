// The size of a JSON text, found before a parser reads it: parsed values take memory, and deep ones take stack.
#pragma once

#include <cstddef>
#include <string_view>

namespace alabaster::hd::support {

struct JsonBounds {
  size_t values = 0;                            // about: brackets and commas outside of strings
  size_t containers = 0;                        // objects and arrays
  size_t too_deep_at = std::string_view::npos;  // the first byte beyond the depth; npos: there is none
};
/// Stops at the first byte that lies deeper than `most_depth` brackets.
JsonBounds bounds_of_json(std::string_view text, size_t most_depth);

}  // namespace alabaster::hd::support
