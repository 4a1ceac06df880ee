#include "core/texture/distinct_colors.h"

#include <cstring>

namespace alabaster {

void DistinctColors::find(const ImageRows& rows, const ImageLayout& layout, size_t first, size_t count) {
  ++round_;
  places_.resize(count);
  rgba_.clear();
  bytes_.clear();
  if (layout.bytes)
    find_bytes(&rows.bytes[first * layout.channels], layout);
  else
    find_floats(&rows.floats[first * layout.channels], layout);
}

// The table holds the last colour of each hash (Fibonacci's).
void DistinctColors::find_bytes(const uint8_t* texel, const ImageLayout& layout) {
  constexpr float kUnit = 1.0f / 255;
  const auto [r, g, b] = layout.rgb;
  const size_t channels = layout.channels;
  uint32_t last = UINT32_MAX, place = 0;
  const auto place_of = [&](uint32_t color) {
    Known& known = known_[(color * 0x9e3779b1u) >> 20];
    if (known.round == round_ && known.color == color) return known.place;
    known = {color, uint32_t(bytes_.size()), round_};
    bytes_.push_back({uint8_t(color), uint8_t(color >> 8), uint8_t(color >> 16)});
    for (const uint8_t byte : bytes_.back()) rgba_.push_back(float(byte) * kUnit);
    rgba_.push_back(1);
    return known.place;
  };
  for (uint32_t& to : places_) {
    const uint32_t color = uint32_t(texel[r]) | uint32_t(texel[g]) << 8 | uint32_t(texel[b]) << 16;
    if (color != last) last = color, place = place_of(color);
    to = place;
    texel += channels;
  }
}

void DistinctColors::find_floats(const float* texel, const ImageLayout& layout) {
  std::array<float, 3> last{};
  const auto value = [&](size_t i) { return layout.rgb[i] == ImageLayout::kNoChannel ? 0.0f : texel[layout.rgb[i]]; };
  for (uint32_t& to : places_) {
    const std::array<float, 3> color{value(0), value(1), value(2)};
    if (rgba_.empty() || std::memcmp(&color, &last, sizeof color) != 0)
      rgba_.insert(rgba_.end(), {color[0], color[1], color[2], 1});
    to = uint32_t(rgba_.size() / 4 - 1);
    last = color;
    texel += layout.channels;
  }
}

}  // namespace alabaster
