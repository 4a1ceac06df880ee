#include "delegate/rendering/pixel_format.h"

#include <half.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

namespace alabaster::hd::rendering {
namespace {

// Bytes of a component, which tell its type: 1 unorm, 2 half, 4 float, but for int32.
size_t component_size(Format format) {
  return FormatSize(format) / static_cast<size_t>(std::max(1, FormatComponents(format)));
}

void convert(float value, uint8_t* component) {
  *component = value > 0 ? static_cast<uint8_t>(std::min(value, 1.0f) * 255.0f + 0.5f) : uint8_t(0);
}
void convert(float value, int32_t* component) {
  const double rounded = std::isnan(value) ? 0.0 : std::round(static_cast<double>(value));
  *component = static_cast<int32_t>(std::clamp(rounded, -2147483648.0, 2147483647.0));
}
template <class T>
void convert(float value, T* component) {
  *component = value;
}

template <class T>
void write_as(std::span<const float> values, size_t components, size_t wanted, uint8_t* pixels) {
  for (; !values.empty(); values = values.subspan(components))
    for (size_t i = 0; i < wanted; ++i, pixels += sizeof(T)) {
      T component;
      convert(i < components ? values[i] : i == 3 ? 1.0f : 0.0f, &component);
      std::memcpy(pixels, &component, sizeof component);
    }
}

template <class T>
float read_as(const uint8_t* component) {
  T value;
  std::memcpy(&value, component, sizeof value);
  return static_cast<float>(value);
}

float read_component(const uint8_t* component, Format format, size_t size) {
  if (size == 1) return static_cast<float>(*component) / 255;
  if (size == 2) return read_as<half>(component);
  return format == Format::int32 ? read_as<int32_t>(component) : read_as<float>(component);
}

}  // namespace

void write_pixels(std::span<const float> values, size_t components, Format format, uint8_t* pixels) {
  const auto wanted = static_cast<size_t>(FormatComponents(format));
  const size_t size = component_size(format);
  if (size == 1) return write_as<uint8_t>(values, components, wanted, pixels);
  if (size == 2) return write_as<half>(values, components, wanted, pixels);
  if (format == Format::int32) return write_as<int32_t>(values, components, wanted, pixels);
  if (wanted != components) return write_as<float>(values, components, wanted, pixels);
  std::memcpy(pixels, values.data(), values.size_bytes());
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
  const auto components = static_cast<size_t>(FormatComponents(format));
  const size_t size = component_size(format);
  for (; !rgba.empty(); rgba = rgba.subspan(4), pixels += components * size)
    for (size_t i = 0; i < 4; ++i)
      rgba[i] = i < components ? read_component(pixels + i * size, format, size) : i == 3 ? 1.0f : 0.0f;
}

void write_clear(const Value& clear, Format format, uint8_t* pixel) {
  std::array<double, 4> given{0, 0, 0, 1};
  if (clear.components(&given) < 2) given.fill(clear.number_or(0));
  std::array<float, 4> values{};
  for (size_t i = 0; i < 4; ++i) values[i] = static_cast<float>(given[i]);
  write_pixels(values, 4, format, pixel);
}

AovDescriptor default_aov_descriptor(const Token& name) {
  const AovInfo* const aov = find_aov(name.str());
  if (!aov) return {};
  constexpr Format kFormats[] = {Format::float32, Format::float32vec2, Format::float32vec3, Format::float32vec4};
  const float b = aov->background;
  const Value clears[] = {b, Vec2f(b), Vec3f(b), Vec4f(b)};
  const auto last = static_cast<size_t>(aov->components()) - 1;
  AovDescriptor descriptor;
  descriptor.format = aov->is_integer() ? Format::int32 : kFormats[last];
  descriptor.clearValue = aov->is_integer() ? Value(static_cast<int32_t>(b)) : clears[last];
  return descriptor;
}

}  // namespace alabaster::hd::rendering
