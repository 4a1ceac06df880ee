#include "delegate/rendering/pixel_format.h"

#include <gtest/gtest.h>
#include <half.h>

#include <cstring>
#include <limits>

#include "core/film/aov.h"

namespace alabaster::hd::rendering {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

template <class T>
std::vector<T> written(const std::vector<float>& values, int components, Format format) {
  const size_t count = values.size() / static_cast<size_t>(components);
  std::vector<T> out(count * FormatSize(format) / sizeof(T));
  write_pixels(values, static_cast<size_t>(components), format, reinterpret_cast<uint8_t*>(out.data()));
  return out;
}

template <class T>
std::vector<T> cleared(const Value& clear, Format format) {
  std::vector<T> out(FormatSize(format) / sizeof(T));
  write_clear(clear, format, reinterpret_cast<uint8_t*>(out.data()));
  return out;
}

TEST(PixelFormat, MissingComponentsAreZeroAndAMissingFourthIsOne) {
  EXPECT_EQ(written<float>({5, 6}, 1, Format::float32vec4), (std::vector<float>{5, 0, 0, 1, 6, 0, 0, 1}));
  EXPECT_EQ(written<float>({1, 2, 3}, 3, Format::float32vec4), (std::vector<float>{1, 2, 3, 1}));
  EXPECT_EQ(written<float>({1, 2, 3, 4}, 4, Format::float32vec4), (std::vector<float>{1, 2, 3, 4}));
}

TEST(PixelFormat, ComponentsBeyondTheFormatsAreDropped) {
  EXPECT_EQ(written<float>({1, 2, 3, 4, 5, 6, 7, 8}, 4, Format::float32vec3), (std::vector<float>{1, 2, 3, 5, 6, 7}));
  EXPECT_EQ(written<float>({1, 2, 3, 4, 5, 6}, 3, Format::float32), (std::vector<float>{1, 4}));
}

TEST(PixelFormat, UnormClampsRoundsAndTakesNotANumberForZero) {
  EXPECT_EQ(written<uint8_t>({0, 1, 0.5f, -3, 7, kNan, kInf, -kInf, 1.49f / 255, 1.51f / 255}, 1, Format::unorm8),
            (std::vector<uint8_t>{0, 255, 128, 0, 255, 0, 255, 0, 1, 2}));
  EXPECT_EQ(written<uint8_t>({0.2f, 0.4f, 0.6f}, 3, Format::unorm8vec4), (std::vector<uint8_t>{51, 102, 153, 255}));
}

TEST(PixelFormat, HalfRoundsToNearestAndKeepsWhatIsNotFinite) {
  const auto bits = written<uint16_t>({1, 0.1f, 1e9f, kNan}, 1, Format::float16);
  EXPECT_EQ(bits[0], 0x3c00);
  EXPECT_EQ(bits[1], Imath::half(0.1f).bits());
  EXPECT_EQ(bits[2], 0x7c00) << "infinity";
  EXPECT_EQ(bits[3] & 0x7c00, 0x7c00);
  EXPECT_NE(bits[3] & 0x03ff, 0) << "not a number";
}

TEST(PixelFormat, FloatsToIntRoundAndClamp) {
  EXPECT_EQ(written<int32_t>({1.4f, 1.6f, -1.6f, kNan, 1e20f, -kInf}, 1, Format::int32),
            (std::vector<int32_t>{1, 2, -2, 0, 2147483647, -2147483647 - 1}));
}

TEST(PixelFormat, IdsAreExactInIntAndCastElsewhere) {
  const int32_t ids[] = {-1, 16777217, 3};
  std::vector<int32_t> exact(3);
  write_pixels(ids, Format::int32, reinterpret_cast<uint8_t*>(exact.data()));
  EXPECT_EQ(exact, (std::vector<int32_t>{-1, 16777217, 3}));
  std::vector<float> floats(6);
  write_pixels(ids, Format::float32vec2, reinterpret_cast<uint8_t*>(floats.data()));
  EXPECT_EQ(floats, (std::vector<float>{-1, 0, 16777216, 0, 3, 0}));
}

TEST(PixelFormat, ClearValuesAreNumbersOrVectors) {
  EXPECT_EQ(cleared<float>(0.5f, Format::float32vec4), (std::vector<float>{0.5f, 0.5f, 0.5f, 0.5f}));
  EXPECT_EQ(cleared<float>(Vec3f(1, 2, 3), Format::float32vec4), (std::vector<float>{1, 2, 3, 1}));
  EXPECT_EQ(cleared<float>(Vec4f(1, 2, 3, 4), Format::float32vec4), (std::vector<float>{1, 2, 3, 4}));
  EXPECT_EQ(cleared<float>(Value(), Format::float32), (std::vector<float>{0}));
  EXPECT_EQ(cleared<int32_t>(int32_t(-1), Format::int32), (std::vector<int32_t>{-1}));
}

TEST(PixelFormat, DescriptorsFitTheirAovs) {
  for (const AovInfo& aov : kAovs) {
    const AovDescriptor descriptor = default_aov_descriptor(aov.name);
    EXPECT_EQ(FormatComponents(descriptor.format), aov.components()) << aov.name;
    EXPECT_EQ(descriptor.format == Format::int32, aov.is_integer()) << aov.name;
    EXPECT_FALSE(descriptor.clearValue.empty()) << aov.name;
  }
  EXPECT_EQ(default_aov_descriptor("primId").clearValue, Value(int32_t(-1))) << "the background";
  EXPECT_EQ(default_aov_descriptor("depth").clearValue, Value(1.0f)) << "the far plane";
  EXPECT_EQ(default_aov_descriptor("caustics").format, Format::invalid);
}

}  // namespace
}  // namespace alabaster::hd::rendering
