// Limits of glTF documents, for reader and writer.
#pragma once

#include <cstddef>

namespace alabaster::hd::support {

/// Documents of more values are refused: '{', '[' and ',' outside of strings are counted.
inline constexpr size_t kMostGltfValues = 10'000'000;

}  // namespace alabaster::hd::support
