// Sizes of pictures as texts.
#pragma once

#include <cstdint>
#include <string>

namespace alabaster::hd::support {

/// "960 x 640", in sentences.
inline std::string size_text(int64_t width, int64_t height) {
  return std::to_string(width) + " x " + std::to_string(height);
}

/// "960x640", as options of the command line have it.
inline std::string size_option(int64_t width, int64_t height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

}  // namespace alabaster::hd::support
