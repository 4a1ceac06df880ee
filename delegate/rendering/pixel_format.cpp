#include "delegate/rendering/pixel_format.h"

#include <half.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>

namespace alabaster::hd::rendering {
namespace {

void write_component(float value, Format format, std::ptrdiff_t i, uint8_t* pixel) {
  switch (format) {
    case Format::unorm8:
    case Format::unorm8vec3:
    case Format::unorm8vec4:
      pixel[i] = value > 0 ? static_cast<uint8_t>(std::min(value, 1.0f) * 255.0f + 0.5f) : uint8_t(0);
      return;
    case Format::float16:
    case Format::float16vec3:
    case Format::float16vec4: {
      const half h(value);
      std::memcpy(pixel + 2 * i, &h, 2);
      return;
    }
    case Format::int32: {
      const double rounded = std::isnan(value) ? 0.0 : std::round(static_cast<double>(value));
      const auto integer = static_cast<int32_t>(std::clamp(rounded, -2147483648.0, 2147483647.0));
      std::memcpy(pixel, &integer, 4);
      return;
    }
    default:
      std::memcpy(pixel + 4 * i, &value, 4);
  }
}

float read_component(const uint8_t* pixel, Format format, std::ptrdiff_t i) {
  switch (format) {
    case Format::unorm8:
    case Format::unorm8vec3:
    case Format::unorm8vec4:
      return static_cast<float>(pixel[i]) / 255;
    case Format::float16:
    case Format::float16vec3:
    case Format::float16vec4: {
      half h;
      std::memcpy(&h, pixel + 2 * i, 2);
      return h;
    }
    case Format::int32: {
      int32_t integer;
      std::memcpy(&integer, pixel, 4);
      return static_cast<float>(integer);
    }
    default: {
      float value;
      std::memcpy(&value, pixel + 4 * i, 4);
      return value;
    }
  }
}

AovDescriptor described(Format format, Value clear) {
  AovDescriptor descriptor;
  descriptor.format = format;
  descriptor.clearValue = std::move(clear);
  return descriptor;
}

}  // namespace

void write_pixels(std::span<const float> values, size_t components, Format format, uint8_t* pixels) {
  const auto wanted = static_cast<size_t>(FormatComponents(format));
  const size_t size = FormatSize(format);
  if (wanted == components && size == wanted * sizeof(float) && format != Format::int32) {
    std::memcpy(pixels, values.data(), values.size_bytes());
    return;
  }
  for (; !values.empty(); values = values.subspan(components), pixels += size)
    for (size_t i = 0; i < wanted; ++i)
      write_component(i < components ? values[i]
                      : i == 3       ? 1.0f
                                     : 0.0f,
                      format, static_cast<std::ptrdiff_t>(i), pixels);
}

void write_pixels(std::span<const int32_t> values, Format format, uint8_t* pixels) {
  if (format == Format::int32) {
    std::memcpy(pixels, values.data(), values.size_bytes());
    return;
  }
  const size_t size = FormatSize(format);
  for (const int32_t value : values) {
    const auto number = static_cast<float>(value);
    write_pixels({&number, 1}, 1, format, pixels);
    pixels += size;
  }
}

void read_pixels(const uint8_t* pixels, Format format, std::span<float> rgba) {
  const int components = FormatComponents(format);
  const size_t size = FormatSize(format);
  for (; !rgba.empty(); rgba = rgba.subspan(4), pixels += size)
    for (int i = 0; i < 4; ++i)
      rgba[static_cast<size_t>(i)] = i < components ? read_component(pixels, format, i) : i == 3 ? 1.0f : 0.0f;
}

void write_clear(const Value& clear, Format format, uint8_t* pixel) {
  std::array<double, 4> given{0, 0, 0, 1};
  if (clear.components(&given) < 2) given.fill(clear.number_or(0));
  std::array<float, 4> values{};
  for (size_t i = 0; i < 4; ++i) values[i] = static_cast<float>(given[i]);
  write_pixels(values, 4, format, pixel);
}

AovDescriptor default_aov_descriptor(const Token& name) {
  const AovInfo* aov = find_aov(name.str());
  if (!aov) return {};
  const float b = aov->background;
  if (aov->is_integer()) return described(Format::int32, static_cast<int32_t>(b));
  switch (aov->components()) {
    case 1:
      return described(Format::float32, b);
    case 2:
      return described(Format::float32vec2, Vec2f(b));
    case 3:
      return described(Format::float32vec3, Vec3f(b));
    default:
      return described(Format::float32vec4, Vec4f(b));
  }
}

}  // namespace alabaster::hd::rendering
