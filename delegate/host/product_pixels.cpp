#include "delegate/host/product_pixels.h"

#include <half.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/color/color_config.h"
#include "core/math/largest_half.h"

namespace alabaster::hd::host {
namespace {

/// A number in [0, 1) that depends only on the pixel's place in the full frame, so that crops and re-renders agree
/// (PCG's output permutation, O'Neill 2014, over a multiplicative mix of the position).
float dither_of(int x, int y, int channel) {
  uint32_t h = uint32_t(x) * 0x9e3779b1u ^ uint32_t(y) * 0x85ebca77u ^ uint32_t(channel + 1) * 0xc2b2ae3du;
  h = h * 747796405u + 2891336453u;
  h = ((h >> ((h >> 28) + 4)) ^ h) * 277803737u;
  h = (h >> 22) ^ h;
  return float(h >> 8) * 0x1p-24f;
}

size_t bytes_of(ChannelStore store) {
  switch (store) {
    case ChannelStore::uint8:
      return 1;
    case ChannelStore::half:
    case ChannelStore::uint16:
      return 2;
    default:
      return 4;
  }
}

uint32_t count_of(float v) {
  return v >= 0 && v < 4294967040.0f ? uint32_t(v + 0.5f) : UINT32_MAX;
}

/// Rounds v, scaled to levels, down after adding `threshold` levels.
template <class Level>
Level quantise(float v, float threshold) {
  constexpr auto kLevels = float(std::numeric_limits<Level>::max());
  const float scaled = (v > 0 ? std::min(v, 1.0f) : 0.0f) * kLevels;  // a NaN is black
  return Level(std::min(scaled + threshold, kLevels));
}

}  // namespace

RowEncoder::RowEncoder(const ProductPlan& plan, const ProductImage& image, const ColorTransform& transform)
    : plan_(plan), image_(image), transform_(transform), width_(size_t(image.framing.dataWindow.width())) {
  for (const PlannedChannel& channel : plan.channels) {
    const AovPixels* pixels = &image.aovs.at(channel.aov.str());
    const auto found = std::find(colors_.begin(), colors_.end(), pixels);
    const size_t color = size_t(found - colors_.begin());
    if (channel.is_color && found == colors_.end()) colors_.push_back(pixels);
    columns_.push_back({&channel, pixels, color, pixel_bytes_});
    pixel_bytes_ += bytes_of(channel.store);
  }
}

void RowEncoder::encode(int begin, int end, uint8_t* out) const {
  constexpr int kRowsOfATask = 4;
  tbb::parallel_for(tbb::blocked_range<int>(begin, end, kRowsOfATask), [&](const tbb::blocked_range<int>& rows) {
    Scratch scratch(colors_.size(), std::vector<float>(4 * width_));
    for (int row = rows.begin(); row < rows.end(); ++row)
      encode_row(row, scratch, out + size_t(row - begin) * row_bytes());
  });
}

void RowEncoder::encode_row(int row, Scratch& scratch, uint8_t* out) const {
  for (size_t i = 0; i < colors_.size(); ++i) convert(*colors_[i], row, scratch[i]);
  for (const Column& column : columns_) store(column, row, scratch, out + column.offset);
}

// EXR keeps colour premultiplied, as compositors expect. PNG and TIFF hold straight colour, so the view is applied to
// straight colour. JPEG has no alpha and holds the frame over black, which is the premultiplied colour.
void RowEncoder::convert(const AovPixels& pixels, int row, std::vector<float>& rgba) const {
  const size_t components = size_t(pixels.components);
  const bool straight = components == 4 && (plan_.kind == FileKind::png || plan_.kind == FileKind::tiff);
  const float* in = &pixels.floats[image_.row_begin(pixels, row)];
  for (size_t x = 0; x < width_; ++x) {
    const float alpha = components == 4 ? in[components * x + 3] : 1.0f;
    const float scale = straight && alpha > 0 && alpha < 1 ? 1 / alpha : 1.0f;
    for (size_t c = 0; c < 3; ++c) rgba[4 * x + c] = in[components * x + c] * scale;
    rgba[4 * x + 3] = 1;
  }
  // Unconverted colours keep their full float range. A NaN would spread through every filter that reads the file.
  if (!transform_.is_noop()) return transform_.apply(rgba.data(), width_);
  for (float& v : rgba) v = std::isfinite(v) ? v : 0.0f;
}

template <class Value>
void RowEncoder::store_as(const Column& column, int row, uint8_t* out, const Value& value) const {
  const PlannedChannel& channel = *column.channel;
  const auto put_all = [&](const auto& stored) {
    for (size_t x = 0; x < width_; ++x) {
      const auto v = stored(x);
      std::memcpy(out + x * pixel_bytes_, &v, sizeof v);
    }
  };
  switch (channel.store) {
    case ChannelStore::half:
      return put_all([&](size_t x) { return Imath::half(std::clamp(value(x), -kLargestHalf, kLargestHalf)); });
    case ChannelStore::uint8: {
      // Dither hides banding in 8 bits. It leaves exact levels such as black and white alone: only a value between two
      // levels can round either way.
      const Rect2i& window = image_.framing.dataWindow;
      if (!channel.is_color || !plan_.display_referred)
        return put_all([&](size_t x) { return quantise<uint8_t>(value(x), 0.5f); });
      return put_all([&](size_t x) {
        return quantise<uint8_t>(value(x), dither_of(window.minX + int(x), window.minY + row, channel.component));
      });
    }
    case ChannelStore::uint16:
      return put_all([&](size_t x) { return quantise<uint16_t>(value(x), 0.5f); });
    case ChannelStore::uint32:
      return put_all([&](size_t x) { return count_of(value(x)); });
    case ChannelStore::float32:
      return put_all([&](size_t x) { return value(x); });
  }
}

void RowEncoder::store(const Column& column, int row, const Scratch& scratch, uint8_t* out) const {
  const PlannedChannel& channel = *column.channel;
  const AovPixels& pixels = *column.pixels;
  const size_t components = size_t(pixels.components), component = size_t(channel.component);
  const size_t first = image_.row_begin(pixels, row) + component;
  if (channel.is_color) {
    const float* rgba = scratch[column.color].data() + component;
    store_as(column, row, out, [=](size_t x) { return rgba[4 * x]; });
  } else if (!pixels.ints.empty() && channel.store == ChannelStore::uint32) {
    for (size_t x = 0; x < width_; ++x)
      std::memcpy(out + x * pixel_bytes_, &pixels.ints[first + x * components], sizeof(uint32_t));
  } else if (!pixels.ints.empty()) {
    const int32_t* in = pixels.ints.data() + first;
    store_as(column, row, out, [=](size_t x) { return float(in[x * components]); });
  } else if (channel.is_distance) {
    const float* in = pixels.floats.data() + first;
    store_as(column, row, out, [=](size_t x) { return in[x * components] > 0 ? in[x * components] : kFarAway; });
  } else {
    const float* in = pixels.floats.data() + first;
    store_as(column, row, out, [=](size_t x) { return in[x * components]; });
  }
}

}  // namespace alabaster::hd::host
