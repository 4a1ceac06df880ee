// AOVs that are no light, as colours.
#include "delegate/view/data_view.h"

#include <gtest/gtest.h>

#include <cmath>

namespace alabaster::view {
namespace {

std::array<float, 4> shown(DataKind kind, std::array<float, 2> range, std::array<float, 4> pixel) {
  DataView(kind, range).Apply(pixel);
  return pixel;
}

TEST(DataView, KnowsEachAov) {
  for (const char* light : {"color", "diffuse", "subsurface", "specular", "emission", "albedo", "denoised", "error"})
    EXPECT_EQ(data_kind(light), DataKind::light) << light;
  EXPECT_EQ(data_kind("normal"), DataKind::direction);
  EXPECT_EQ(data_kind("Peye"), DataKind::vector);
  EXPECT_EQ(data_kind("primvars:st"), DataKind::vector);
  EXPECT_EQ(data_kind("cameraDepth"), DataKind::number);
  EXPECT_EQ(data_kind("sampleCount"), DataKind::number);
  EXPECT_EQ(data_kind("nonfiniteSamples"), DataKind::number);
  EXPECT_EQ(data_kind("primId"), DataKind::id);
}

TEST(DataView, NumbersAreGrayBetweenTheirRangesEnds) {
  EXPECT_EQ(shown(DataKind::number, {2, 6}, {2, 0, 0, 1}), (std::array<float, 4>{0, 0, 0, 1}));
  EXPECT_EQ(shown(DataKind::number, {2, 6}, {5, 0, 0, 1}), (std::array<float, 4>{0.75f, 0.75f, 0.75f, 1}));
  EXPECT_EQ(shown(DataKind::number, {2, 6}, {INFINITY, 0, 0, 1})[0], 1) << "the distance of the background";
  EXPECT_EQ(shown(DataKind::direction, {0, 1}, {-1, 0, 1, 0}), (std::array<float, 4>{0, 0.5f, 1, 1}));
}

TEST(DataView, IdsGetColoursOfTheirOwn) {
  EXPECT_EQ(shown(DataKind::id, {0, 1}, {-1, 0, 0, 1}), (std::array<float, 4>{0, 0, 0, 1})) << "background";
  for (int id = 0; id < 20; ++id) {
    const auto one = shown(DataKind::id, {0, 1}, {float(id), 0, 0, 1});
    const auto next = shown(DataKind::id, {0, 1}, {float(id + 1), 0, 0, 1});
    const float away = std::abs(one[0] - next[0]) + std::abs(one[1] - next[1]) + std::abs(one[2] - next[2]);
    EXPECT_GT(away, 0.2f) << id;
    EXPECT_GT(one[0] + one[1] + one[2], 0.5f) << "not taken for the background";
  }
}

TEST(DataView, TheRangeLeavesOutWhatIsNoNumber) {
  const float values[] = {3, NAN, 1, INFINITY, 2};
  EXPECT_EQ(finite_range(values, nullptr, 5, 1), (std::array<float, 2>{1, 3}));
  const int32_t ids[] = {0, 0, -1, 0, 0};
  EXPECT_EQ(finite_range(values, ids, 5, 1), (std::array<float, 2>{2, 3}));
  EXPECT_EQ(finite_range(values, nullptr, 0, 1), (std::array<float, 2>{0, 1}));
  const float flat[] = {7, 7};
  const auto range = finite_range(flat, nullptr, 2, 1);
  EXPECT_LT(range[0], range[1]);
}

}  // namespace
}  // namespace alabaster::view
