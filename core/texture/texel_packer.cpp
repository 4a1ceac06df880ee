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
uint8_t byte_of(float value) {
  return static_cast<uint8_t>(std::lround(value * 255));
}

/// The first of each three.
template <class T>
void keep_one_of_three(std::vector<T>* elements) {
  for (size_t i = 0; i < elements->size() / 3; ++i) (*elements)[i] = (*elements)[3 * i];
  elements->resize(elements->size() / 3);
  elements->shrink_to_fit();
}

}  // namespace

// Memory is reserved at once but touched only as rows arrive: a small file that claims to be huge costs nothing.
TexelPacker::TexelPacker(const ImageLayout& layout, MemoryReservation* memory) : layout_(layout), memory_(*memory) {
  const size_t element = layout.bytes ? sizeof(uint8_t) : sizeof(uint16_t);
  const size_t alpha = layout.alpha ? sizeof(uint16_t) + (layout.bytes ? sizeof(uint8_t) : 0) : 0;
  hold(texels() * (3 * element + alpha));
  if (layout.bytes)
    palette_ = Palette(), bytes_.reserve(3 * texels());
  else
    halves_.reserve(3 * texels());
}

void TexelPacker::add(std::span<const float> pixels, std::span<const float> rgba) {
  const size_t count = rgba.size() / 4;
  for (size_t i = 0; i < count; ++i) {
    const float *const pixel = &pixels[i * layout_.channels], *const c = &rgba[4 * i];
    const auto clamped = [](float v) { return half_bits(std::clamp(v, -kLargestHalf, kLargestHalf)); };
    add_color(pixel, {clamped(c[0]), clamped(c[1]), clamped(c[2])});
    if (layout_.alpha) add_alpha(count_ + i, pixel[*layout_.alpha]);
  }
  count_ += count;
}

void TexelPacker::add_color(const float* pixel, const Color& color) {
  if (palette_) {
    std::array<uint8_t, 3> bytes;
    for (size_t c = 0; c < 3; ++c) bytes[c] = byte_of(pixel[layout_.rgb[c]]);
    if (fits_palette(bytes, color)) {
      is_grey_ = is_grey_ && bytes[0] == bytes[1] && bytes[0] == bytes[2];
      bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
      return;
    }
    leave_palette();
  }
  is_grey_ = is_grey_ && color[0] == color[1] && color[0] == color[2];
  halves_.insert(halves_.end(), color.begin(), color.end());
}

bool TexelPacker::fits_palette(const std::array<uint8_t, 3>& bytes, const Color& color) {
  for (size_t c = 0; c < 3; ++c) {
    const size_t b = bytes[c];
    if (!palette_->known[c][b]) palette_->known[c][b] = true, palette_->values[c][b] = color[c];
    if (palette_->values[c][b] != color[c]) return false;
  }
  return true;
}

void TexelPacker::leave_palette() {
  hold(3 * texels() * sizeof(uint16_t));
  halves_.reserve(3 * texels());
  is_grey_ = true;
  for (size_t i = 0; i < bytes_.size(); i += 3) {
    const auto value = [&](size_t c) { return palette_->values[c][bytes_[i + c]]; };
    const Color color{value(0), value(1), value(2)};
    is_grey_ = is_grey_ && color[0] == color[1] && color[0] == color[2];
    halves_.insert(halves_.end(), color.begin(), color.end());
  }
  std::vector<uint8_t>().swap(bytes_);
  palette_.reset();
}

void TexelPacker::add_alpha(size_t texel, float alpha) {
  if (alpha_.empty()) {
    if (alpha == 1) return;
    alpha_.assign(size_t(layout_.width) * size_t(layout_.height), half_bits(1));
  }
  alpha_[texel] = half_bits(std::isfinite(alpha) ? std::clamp(alpha, 0.0f, 1.0f) : 1.0f);
}

PackedImage TexelPacker::take() {
  PackedImage image;
  const Vec2i size(layout_.width, layout_.height);
  // Small images cost less without a palette.
  if (palette_ && bytes_.size() / (is_grey_ ? 3 : 1) < sizeof(float) * 3 * 256) leave_palette();
  image.is_grey = is_grey_;
  if (is_grey_) keep_one_of_three(&bytes_), keep_one_of_three(&halves_);
  if (!palette_) {
    image.halves = {size, std::move(halves_), {}};
    if (!alpha_.empty()) image.alpha_halves = {size, std::move(alpha_), {}};
    return image;
  }
  image.bytes = {size, std::move(bytes_), {}};
  image.bytes.palette.reserve(size_t(3) * 256);
  for (size_t c = 0; c < 3; ++c)
    for (size_t b = 0; b < 256; ++b)
      image.bytes.palette.push_back(palette_->known[c][b] ? from_bits(palette_->values[c][b]) : 0.0f);
  if (alpha_.empty()) return image;
  image.alpha_bytes.size = size;
  image.alpha_bytes.elements.reserve(alpha_.size());
  image.alpha_bytes.palette.reserve(256);
  for (const uint16_t alpha : alpha_) image.alpha_bytes.elements.push_back(byte_of(from_bits(alpha)));
  for (int b = 0; b < 256; ++b) image.alpha_bytes.palette.push_back(from_bits(half_bits(static_cast<float>(b) / 255)));
  return image;
}

}  // namespace alabaster
