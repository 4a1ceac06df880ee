// How the values of a display space are coded, for the tags of image files.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

namespace alabaster {

/// sRGB has neither code points nor a gamma: it needs no tag.
struct DisplayEncoding {
  uint8_t primaries = 0, transfer = 0;       // code points of ITU-T H.273
  float gamma = 0;                           // else the display's, with
  std::array<float, 8> chromaticities = {};  // CIE xy of red, green, blue, white
  bool is_tagged() const { return primaries != 0 || gamma > 0; }
};

}  // namespace alabaster
