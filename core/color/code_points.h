// How the values of a display space are coded.
#pragma once

#include <cstdint>

namespace alabaster {

/// Code points of ITU-T H.273.
struct CodePoints {
  uint8_t primaries = 0, transfer = 0;
  bool operator==(const CodePoints&) const = default;
};
inline constexpr CodePoints kSrgbCodePoints{1, 13};

}  // namespace alabaster
