// The range of 16-bit floats (IEEE 754 binary16), in which files and displays hold colours.
#pragma once

namespace alabaster {

inline constexpr float kLargestHalf = 65504.0f;

}  // namespace alabaster
