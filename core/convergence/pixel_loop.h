// Loops over the pixels of a frame on all threads of the caller's TBB arena. Blocks of pixels have a fixed size, and
// the sums of blocks are added in order, so no bit depends on the number of threads.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include <tbb/parallel_for.h>

#include "core/diagnostics/cancel.h"
#include "core/math/float_environment.h"

namespace alabaster {

inline constexpr size_t kPixelBlock = 4096;

/// visit(block, begin, end) for the pixels [begin, end) of each block. Throws BuildCancelled.
template <class Visit>
void for_pixel_blocks(size_t pixels, const Visit& visit, const CancelToken& cancel = {}) {
  tbb::parallel_for(size_t(0), (pixels + kPixelBlock - 1) / kPixelBlock, [&](size_t block) {
    const FloatEnvironment environment;
    const size_t begin = block * kPixelBlock;
    if (!cancel.is_cancelled()) visit(block, begin, std::min(begin + kPixelBlock, pixels));
  });
  cancel.check();
}

/// The sum over all pixels: add(pixel, &sum) adds one pixel, and Sum has +=.
template <class Sum, class Add>
Sum sum_over_pixels(size_t pixels, const Add& add, const CancelToken& cancel = {}) {
  std::vector<Sum> sums((pixels + kPixelBlock - 1) / kPixelBlock);
  for_pixel_blocks(
      pixels,
      [&](size_t block, size_t begin, size_t end) {
        Sum sum{};
        for (size_t i = begin; i < end; ++i) add(i, &sum);
        sums[block] = sum;
      },
      cancel);
  Sum total{};
  for (const Sum& sum : sums) total += sum;
  return total;
}

}  // namespace alabaster
