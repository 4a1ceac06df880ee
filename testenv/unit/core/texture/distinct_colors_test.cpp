#include "core/texture/distinct_colors.h"

#include <gtest/gtest.h>

#include <random>

namespace alabaster {
namespace {

ImageLayout layout(size_t channels, bool bytes) {
  ImageLayout layout;
  layout.channels = channels;
  layout.bytes = bytes;
  if (channels >= 3) layout.rgb = {2, 0, 1};
  return layout;
}

TEST(DistinctColors, EveryTexelFindsItsOwn) {
  std::mt19937 random(5);
  DistinctColors colors;
  for (const size_t channels : std::vector<size_t>{1, 2, 3, 4, 7})
    for (const bool bytes : {true, false})
      for (const unsigned values : {1u, 2u, 17u, 256u}) {
        const ImageLayout of = layout(channels, bytes);
        ImageRows rows;
        for (size_t i = 0; i < 3000 * channels; ++i) {
          const auto value = random() % values;
          bytes ? rows.bytes.push_back(uint8_t(value)) : rows.floats.push_back(float(value) - 1);
        }
        for (const size_t first : {size_t(0), size_t(1000)}) {
          colors.find(rows, of, first, 2000);
          ASSERT_EQ(colors.places().size(), 2000u);
          for (size_t i = 0; i < 2000; ++i)
            for (size_t c = 0; c < 3; ++c) {
              const size_t at = (first + i) * channels + of.rgb[c], place = colors.places()[i];
              ASSERT_EQ(colors.rgba().at(4 * place + c),
                        bytes ? float(rows.bytes[at]) * (1.0f / 255) : rows.floats[at]);
              ASSERT_EQ(colors.rgba()[4 * place + 3], 1);
              ASSERT_TRUE(!bytes || colors.bytes().at(place)[c] == rows.bytes[at]);
            }
        }
      }
}

// Two colours in turn, as in a picture of one bit a texel.
TEST(DistinctColors, AFewColorsAreConvertedOnce) {
  ImageRows rows;
  for (size_t i = 0; i < DistinctColors::kMostTexels; ++i) rows.bytes.push_back(i % 2 ? 255 : 0);
  DistinctColors colors;
  colors.find(rows, layout(1, true), 0, DistinctColors::kMostTexels);
  EXPECT_EQ(colors.bytes().size(), 2u);
  rows.floats.assign(3 * DistinctColors::kMostTexels, 0.25f);
  colors.find(rows, layout(3, false), 0, DistinctColors::kMostTexels);
  EXPECT_EQ(colors.rgba().size(), 4u);
}

}  // namespace
}  // namespace alabaster
