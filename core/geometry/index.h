// Indices of OpenSubdiv and of faces are int, those of containers size_t.
#pragma once

#include <cstddef>

namespace alabaster {

/// Requires i >= 0.
inline size_t at(int i) {
  return static_cast<size_t>(i);
}

}  // namespace alabaster
