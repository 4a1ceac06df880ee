#include "core/texture/texel_store.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <random>
#include <thread>

#include "core/texture/texel_plane.h"
#include "testenv/support/reports.h"

namespace alabaster {
namespace {

template <class Element>
PackedTexels<Element> noise(const Vec2i& size, int count, uint32_t seed) {
  std::mt19937 random(seed);
  PackedTexels<Element> texels{size, {}, {}};
  for (int i = 0; i < size.x * size.y * count; ++i)
    texels.elements.push_back(static_cast<Element>(random() % (sizeof(Element) == 1 ? 256 : 0x7c00)));  // finite halves
  if (sizeof(Element) == 1)
    for (int i = 0; i < 768; ++i) texels.palette.push_back(static_cast<float>(random() % 1000) / 7);
  return texels;
}

// Each of many threads compares texels all over planes that no cache of the least size holds with those in memory.
template <class Element, int kCount>
void expect_equal_planes(const Vec2i& size) {
  TexelPlane<Element, kCount> in_memory, in_file;
  const auto store = std::make_shared<TexelStore>();
  store->set_budget(0);
  ASSERT_TRUE(in_memory.keep(noise<Element>(size, kCount, 5), nullptr));
  ASSERT_TRUE(in_file.keep(noise<Element>(size, kCount, 5), store));
  EXPECT_LT(in_file.memory_bytes(), in_memory.memory_bytes() / 2);
  std::vector<int> wrong(4, 0);
  std::vector<std::thread> threads;
  for (size_t t = 0; t < wrong.size(); ++t)
    threads.emplace_back([&, t] {
      std::mt19937 random(static_cast<uint32_t>(t));
      for (int i = 0; i < 60000; ++i) {
        const int x = static_cast<int>(random()) & 0x7fffffff, y = static_cast<int>(random()) & 0x7fffffff;
        wrong[t] += in_file.color(x % size.x, y % size.y) != in_memory.color(x % size.x, y % size.y);
      }
    });
  for (std::thread& thread : threads) thread.join();
  for (const int w : wrong) EXPECT_EQ(w, 0);
  const uint64_t tiles = (in_memory.memory_bytes() + TexelStore::kTileBytes - 1) / TexelStore::kTileBytes;
  EXPECT_GT(store->fetched(), 4 * tiles) << "tiles came and went";
}

TEST(TexelStore, GivesTheTexelsOfPlanesInMemoryFromAnyThread) {
  expect_equal_planes<uint8_t, 1>({1100, 900});
  expect_equal_planes<uint8_t, 3>({517, 431});
  expect_equal_planes<uint16_t, 1>({700, 643});
  expect_equal_planes<uint16_t, 3>({401, 333});
}

TEST(TexelStore, LendsHalfOfItsBudgetAndReadsEachTileOnceWhereTheRestFits) {
  constexpr size_t kBytes = size_t(256) * 256 * 6;  // of a plane below, in 28 tiles of 64 x 42 texels
  const auto store = std::make_shared<TexelStore>();
  store->set_budget(2 * 28 * TexelStore::kTileBytes);
  {
    TexelPlane<uint16_t, 3> first, second;
    ASSERT_TRUE(first.keep(noise<uint16_t>({256, 256}, 3, 1), store));
    ASSERT_TRUE(second.keep(noise<uint16_t>({256, 256}, 3, 2), store));
    EXPECT_GE(first.memory_bytes(), kBytes);
    EXPECT_LT(second.memory_bytes(), kBytes / 100);
    for (int i = 0; i < 3 * 256 * 256; ++i) second.color(i % 256, i / 256 % 256);
    EXPECT_EQ(store->fetched(), 28u);
  }
  TexelPlane<uint16_t, 3> third;
  ASSERT_TRUE(third.keep(noise<uint16_t>({256, 256}, 3, 3), store));
  EXPECT_GE(third.memory_bytes(), kBytes) << "what was lent is given back";
}

TEST(TexelStore, SaysThatItsFileCannotBeWritten) {
  const char* const held = std::getenv("TMPDIR");
  const std::string before = held ? held : "";
  setenv("TMPDIR", "/no/such/folder", 1);
  const auto store = std::make_shared<TexelStore>();
  store->set_budget(0);
  TexelPlane<uint8_t, 1> plane;
  EXPECT_FALSE(plane.keep(noise<uint8_t>({9, 9}, 1, 1), store));
  EXPECT_NE(errno, 0);
  setenv("TMPDIR", "", 1);
  EXPECT_TRUE(plane.keep(noise<uint8_t>({9, 9}, 1, 1), store)) << "an empty TMPDIR is as none";
  held ? setenv("TMPDIR", before.c_str(), 1) : unsetenv("TMPDIR");
}

}  // namespace
}  // namespace alabaster
