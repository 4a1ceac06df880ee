#include "delegate/support/json_bounds.h"

namespace alabaster::hd::support {

JsonBounds bounds_of_json(std::string_view text, size_t most_depth) {
  JsonBounds bounds;
  size_t depth = 0;
  bool in_string = false;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      if (c == '\\') ++i;
      if (c == '"') in_string = false;
      continue;
    }
    if (c == '"') in_string = true;
    if (c == '{' || c == '[') ++depth, ++bounds.containers;
    if ((c == '}' || c == ']') && depth > 0) --depth;
    if (c == '{' || c == '[' || c == ',') ++bounds.values;
    if (depth > most_depth) {
      bounds.too_deep_at = i;
      return bounds;
    }
  }
  return bounds;
}

}  // namespace alabaster::hd::support
