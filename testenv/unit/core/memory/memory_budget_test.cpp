#include "core/memory/memory_budget.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

namespace alabaster {
namespace {

constexpr size_t kMiB = size_t(1) << 20;

TEST(MemoryBudget, RefusesBeforeTheLimitIsExceededAndSaysWhoHoldsWhat) {
  const auto budget = std::make_shared<MemoryBudget>(10 * kMiB);
  const MemoryReservation meshes(budget, MemoryUse::meshes, 6 * kMiB, "mesh /a");
  MemoryReservation textures(budget, MemoryUse::textures, kMiB, "image a.png");
  try {
    textures.resize(5 * kMiB, "image b.png, 2048 x 2048 pixels,");
    FAIL() << "11 of 10";
  } catch (const std::bad_alloc& e) {
    EXPECT_STREQ(
        e.what(),
        "image b.png, 2048 x 2048 pixels, needs 4 MiB more, but of the memory limit of 10 MiB 7 MiB are in use "
        "by meshes 6 MiB, textures 1 MiB: raise memoryLimit, or make the image smaller");
  }
  EXPECT_EQ(budget->in_use(), 7 * kMiB) << "a refusal changes nothing";
  EXPECT_EQ(textures.bytes(), kMiB);
  EXPECT_EQ(budget->left(), 3 * kMiB);
  textures.resize(4 * kMiB, "all of it");
  EXPECT_EQ(budget->left(), 0u);
  EXPECT_THROW(MemoryReservation(budget, MemoryUse::lights, ~size_t(0), "no sum overflows"), MemoryRefused);
}

TEST(MemoryBudget, TheNumbersOfARefusalDifferWhereTheSizesDo) {
  const auto text_with = [](size_t limit, size_t in_use, size_t more) {
    MemoryBudget budget(limit);
    budget.add(MemoryUse::meshes, in_use);
    const std::string text = budget.refusal(MemoryUse::frames, more, "a frame");
    return text.substr(0, text.find(" by "));
  };
  EXPECT_EQ(text_with(4096 * kMiB, 4096 * kMiB - kMiB / 2, kMiB),
            "a frame needs 1.0 MiB more, but of the memory limit of 4096.0 MiB 4095.5 MiB are in use");
  EXPECT_EQ(text_with(4096 * kMiB, 4096 * kMiB - kMiB / 20, kMiB / 10),
            "a frame needs 0.10 MiB more, but of the memory limit of 4096.00 MiB 4095.96 MiB are in use");
  EXPECT_EQ(text_with(1000, 990, 20),
            "a frame needs 20 bytes more, but of the memory limit of 1000 bytes 990 bytes are in use");
  EXPECT_EQ(text_with(kMiB, kMiB, 1), "a frame needs 1 MiB more, but of the memory limit of 1 MiB 1 MiB are in use");
  EXPECT_EQ(text_with(10 * kMiB + 1, 9 * kMiB + 1, 2 * kMiB),
            "a frame needs 2.0 MiB more, but of the memory limit of 10.0 MiB 9.1 MiB are in use");
}

TEST(MemoryBudget, ThreadsTogetherStayWithinTheLimit) {
  const auto budget = std::make_shared<MemoryBudget>(1000);
  std::atomic<size_t> granted{0};
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&] {
      for (int i = 0; i < 1000; ++i)
        if (budget->take(MemoryUse::tracing, 1)) ++granted;
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(granted, 1000u);
  EXPECT_EQ(budget->in_use(), 1000u);
}

}  // namespace
}  // namespace alabaster
