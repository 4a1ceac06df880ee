#include "core/texture/texel_packer.h"

#include <algorithm>
#include <cmath>

namespace alabaster {
namespace {

constexpr float kLargestHalf = 65504.0f;

uint16_t half_bits(float value) {
  return Imath::half(value).bits();
}
float from_bits(uint16_t bits) {
  Imath::half half;
  half.setBits(bits);
  return half;
}
/// Three of each.
template <class T>
std::vector<T> tripled(const std::vector<T>& elements, size_t room) {
  std::vector<T> result;
  result.reserve(room);
  for (const T& element : elements) result.insert(result.end(), 3, element);
  return result;
}

/// Adds elements of the colours at `places`, one or three of each.
template <class T, class Colors>
void add_elements(std::vector<T>* to, const std::vector<uint32_t>& places, const Colors& colors, size_t width) {
  size_t at = to->size();
  to->resize(at + places.size() * width);
  T* const data = to->data();
  for (const uint32_t place : places)
    for (size_t c = 0; c < width; ++c) data[at++] = colors[place][c];
}

}  // namespace

// Memory is reserved at once but touched only as rows arrive: a small file that claims to be huge costs nothing.
TexelPacker::TexelPacker(const ImageLayout& layout, MemoryReservation* memory) : layout_(layout), memory_(*memory) {
  const size_t element = layout.bytes ? sizeof(uint8_t) : sizeof(uint16_t);
  const size_t alpha = layout.alpha ? sizeof(uint16_t) + (layout.bytes ? sizeof(uint8_t) : 0) : 0;
  hold(texels() * (element + alpha));
  if (layout.bytes)
    palette_ = Palette(), bytes_.reserve(texels());
  else
    halves_.reserve(texels());
}

void TexelPacker::add(const DistinctColors& colors, const ImageRows& rows, size_t first) {
  const auto clamped = [](float v) { return half_bits(std::clamp(v, -kLargestHalf, kLargestHalf)); };
  const std::vector<float>& rgba = colors.rgba();
  colors_.clear();
  for (size_t i = 0; i < rgba.size(); i += 4)
    colors_.push_back({clamped(rgba[i]), clamped(rgba[i + 1]), clamped(rgba[i + 2])});
  choose_storage(colors);
  const std::vector<uint32_t>& places = colors.places();
  if (palette_)
    add_elements(&bytes_, places, colors.bytes(), width());
  else
    add_elements(&halves_, places, colors_, width());
  if (layout_.alpha) add_alpha(rows, first, places.size());
  count_ += places.size();
}

// Before texels of these colours are added.
void TexelPacker::choose_storage(const DistinctColors& colors) {
  const auto& bytes = colors.bytes();
  bool fits = palette_.has_value();
  for (size_t i = 0; i < bytes.size() && fits; ++i) fits = fits_palette(bytes[i], colors_[i]);
  if (palette_ && !fits) leave_palette();
  const auto is_grey = [](const auto& c) { return c[0] == c[1] && c[0] == c[2]; };
  if (is_grey_ && !(palette_ ? std::all_of(bytes.begin(), bytes.end(), is_grey)
                             : std::all_of(colors_.begin(), colors_.end(), is_grey)))
    widen();
}

bool TexelPacker::fits_palette(const std::array<uint8_t, 3>& bytes, const Color& color) {
  for (size_t c = 0; c < 3; ++c) {
    const size_t b = bytes[c];
    if (!palette_->known[c][b]) palette_->known[c][b] = true, palette_->values[c][b] = color[c];
    if (palette_->values[c][b] != color[c]) return false;
  }
  return true;
}

void TexelPacker::widen() {
  const size_t element = palette_ ? sizeof(uint8_t) : sizeof(uint16_t), room = 3 * texels();
  hold(room * element);
  if (palette_)
    bytes_ = tripled(bytes_, room);
  else
    halves_ = tripled(halves_, room);
  memory_.shrink(memory_.bytes() - texels() * element);
  is_grey_ = false;
}

// Equal bytes stay grey only if they became grey colours.
void TexelPacker::leave_palette() {
  const auto& values = palette_->values;
  const auto becomes_grey = [&](uint8_t b) { return values[0][b] == values[1][b] && values[0][b] == values[2][b]; };
  if (is_grey_ && !std::all_of(bytes_.begin(), bytes_.end(), becomes_grey)) widen();
  hold(width() * texels() * sizeof(uint16_t));
  halves_.reserve(width() * texels());
  for (size_t i = 0; i < bytes_.size(); ++i) halves_.push_back(values[i % width()][bytes_[i]]);
  std::vector<uint8_t>().swap(bytes_);
  memory_.shrink(memory_.bytes() - width() * texels());
  palette_.reset();
}

void TexelPacker::add_alpha(const ImageRows& rows, size_t first, size_t count) {
  const size_t channels = layout_.channels, begin = first * channels + *layout_.alpha;
  const auto add = [&](auto* kept, const auto& values, auto opaque, const auto& stored) {
    const auto* const from = values.data() + begin;
    size_t i = 0;
    if (kept->empty()) {
      while (i < count && from[i * channels] == opaque) ++i;
      if (i == count) return;
      kept->assign(texels(), stored(opaque));
    }
    auto* const to = kept->data() + count_;
    for (; i < count; ++i) to[i] = stored(from[i * channels]);
  };
  if (layout_.bytes)
    add(&alpha_bytes_, rows.bytes, uint8_t(255), [](uint8_t alpha) { return alpha; });
  else
    add(&alpha_halves_, rows.floats, 1.0f,
        [](float alpha) { return half_bits(std::isfinite(alpha) ? std::clamp(alpha, 0.0f, 1.0f) : 1.0f); });
}

PackedImage TexelPacker::take() {
  PackedImage image;
  const Vec2i size(layout_.width, layout_.height);
  const auto alpha_of = [](size_t byte) { return half_bits(static_cast<float>(byte) / 255); };
  // Small images cost less without a palette.
  if (palette_ && bytes_.size() < sizeof(float) * 3 * 256) leave_palette();
  image.is_grey = is_grey_;
  if (!palette_) {
    image.halves = {size, std::move(halves_), {}};
    for (const uint8_t alpha : alpha_bytes_) alpha_halves_.push_back(alpha_of(alpha));
    if (!alpha_halves_.empty()) image.alpha_halves = {size, std::move(alpha_halves_), {}};
    return image;
  }
  image.bytes = {size, std::move(bytes_), {}};
  image.bytes.palette.reserve(size_t(3) * 256);
  for (size_t c = 0; c < 3; ++c)
    for (size_t b = 0; b < 256; ++b)
      image.bytes.palette.push_back(palette_->known[c][b] ? from_bits(palette_->values[c][b]) : 0.0f);
  if (alpha_bytes_.empty()) return image;
  image.alpha_bytes = {size, std::move(alpha_bytes_), {}};
  image.alpha_bytes.palette.reserve(256);
  for (size_t b = 0; b < 256; ++b) image.alpha_bytes.palette.push_back(from_bits(alpha_of(b)));
  return image;
}

}  // namespace alabaster
