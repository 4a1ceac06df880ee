#include "core/convergence/pixel_loop.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include <tbb/task_arena.h>

namespace alabaster {
namespace {

// The first block ends last, so blocks that are added as they end are added in another order.
TEST(PixelLoop, SumsAreAddedInOrder) {
  constexpr size_t kBlocks = 40, kPixels = kBlocks * kPixelBlock - 5;
  const auto term = [](size_t i) { return 1 / (static_cast<double>(i / kPixelBlock) + 3.7); };
  double expected = 0;
  for (size_t block = 0; block < kBlocks; ++block) {
    double sum = 0;
    for (size_t i = block * kPixelBlock; i < std::min(kPixels, (block + 1) * kPixelBlock); ++i) sum += term(i);
    expected += sum;
  }
  for (const int threads : {1, 2})
    tbb::task_arena(threads).execute([&] {
      const auto sum = sum_over_pixels<double>(kPixels, [&](size_t i, double* s) {
        if (i == 0) std::this_thread::sleep_for(std::chrono::milliseconds(100));
        *s += term(i);
      });
      EXPECT_EQ(sum, expected) << threads << " threads";
    });
}

TEST(PixelLoop, VisitsEveryPixelOnce) {
  for (const size_t pixels : {size_t(0), size_t(1), kPixelBlock, 3 * kPixelBlock + 1}) {
    std::vector<int> visits(pixels, 0);
    for_pixel_blocks(pixels, [&](size_t block, size_t begin, size_t end) {
      EXPECT_EQ(begin, block * kPixelBlock);
      for (size_t i = begin; i < end; ++i) ++visits[i];
    });
    EXPECT_EQ(visits, std::vector<int>(pixels, 1));
  }
}

}  // namespace
}  // namespace alabaster
