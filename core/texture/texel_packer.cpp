#include "core/texture/texel_packer.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/math/largest_half.h"

namespace alabaster {
namespace {

uint16_t half_bits(float value) {
  return Imath::half(value).bits();
}
float from_bits(uint16_t bits) {
  Imath::half half;
  half.setBits(bits);
  return half;
}
uint32_t float_bits(float value) {
  return std::bit_cast<uint32_t>(value);
}
float clean_alpha(float alpha) {
  return std::isfinite(alpha) ? std::clamp(alpha, 0.0f, 1.0f) : 1.0f;
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
TexelPacker::TexelPacker(const ImageLayout& layout, MemoryReservation* memory, bool floats)
    : layout_(layout),
      memory_(*memory),
      may_be_floats_(floats && !layout.bytes),
      storage_(layout.bytes ? Storage::palette : Storage::halves) {
  const size_t alpha = layout.alpha ? sizeof(uint16_t) + (layout.bytes ? sizeof(uint8_t) : 0) : 0;
  hold(texels() * (element_bytes() + alpha));
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
  choose_storage(colors, rows, first);
  const std::vector<uint32_t>& places = colors.places();
  if (storage_ == Storage::palette)
    add_elements(&bytes_, places, colors.bytes(), width());
  else if (storage_ == Storage::halves)
    add_elements(&halves_, places, colors_, width());
  else
    add_elements(&floats_, places, float_colors_, width());
  if (layout_.alpha) add_alpha(rows, first, places.size());
  count_ += places.size();
}

// Before texels of these colours are added.
void TexelPacker::choose_storage(const DistinctColors& colors, const ImageRows& rows, size_t first) {
  const auto& bytes = colors.bytes();
  bool fits = palette_.has_value();
  for (size_t i = 0; i < bytes.size() && fits; ++i) fits = fits_palette(bytes[i], colors_[i]);
  if (palette_ && !fits) leave_palette();
  if (storage_ == Storage::halves && may_be_floats_ &&
      !(fit_halves(colors.rgba()) && fit_halves(rows, first, colors.places().size())))
    leave_halves();
  if (storage_ == Storage::floats) {
    float_colors_.clear();
    const std::vector<float>& rgba = colors.rgba();
    for (size_t i = 0; i < rgba.size(); i += 4)
      float_colors_.push_back({float_bits(rgba[i]), float_bits(rgba[i + 1]), float_bits(rgba[i + 2])});
  }
  const auto are_grey = [](const auto& all) {
    return std::all_of(all.begin(), all.end(), [](const auto& c) { return c[0] == c[1] && c[0] == c[2]; });
  };
  if (is_grey_ && !(storage_ == Storage::palette  ? are_grey(bytes)
                    : storage_ == Storage::halves ? are_grey(colors_)
                                                  : are_grey(float_colors_)))
    widen();
}

bool TexelPacker::fits_half(float value) const {
  return std::abs(value) <= kLargestHalf && (layout_.halves || from_bits(half_bits(value)) == value);
}

// A file of halves has no more precision than these, but colours of other primaries may be beyond their range.
bool TexelPacker::fit_halves(const std::vector<float>& rgba) const {
  return std::all_of(rgba.begin(), rgba.end(), [this](float v) { return fits_half(v); });
}

bool TexelPacker::fit_halves(const ImageRows& rows, size_t first, size_t count) const {
  if (!layout_.alpha) return true;
  const float* const alpha = &rows.floats[first * layout_.channels + *layout_.alpha];
  for (size_t i = 0; i < count; ++i)
    if (!fits_half(clean_alpha(alpha[i * layout_.channels]))) return false;
  return true;
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
  const size_t room = 3 * texels();
  hold(room * element_bytes());
  if (storage_ == Storage::palette)
    bytes_ = tripled(bytes_, room);
  else if (storage_ == Storage::halves)
    halves_ = tripled(halves_, room);
  else
    floats_ = tripled(floats_, room);
  memory_.shrink(memory_.bytes() - texels() * element_bytes());
  is_grey_ = false;
}

// Texels that were added keep their values.
void TexelPacker::leave_halves() {
  needs_floats_ = true;
  const auto as_floats = [](std::vector<uint16_t>* from, size_t room, std::vector<uint32_t>* to) {
    to->reserve(room);
    for (const uint16_t half : *from) to->push_back(float_bits(from_bits(half)));
    std::vector<uint16_t>().swap(*from);
  };
  const size_t elements = texels() * (width() + (layout_.alpha ? 1 : 0));
  hold(elements * sizeof(float));
  as_floats(&halves_, width() * texels(), &floats_);
  as_floats(&alpha_halves_, alpha_halves_.size(), &alpha_floats_);
  memory_.shrink(memory_.bytes() - elements * sizeof(uint16_t));
  storage_ = Storage::floats;
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
  storage_ = Storage::halves;
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
  else if (storage_ == Storage::halves)
    add(&alpha_halves_, rows.floats, 1.0f, [](float alpha) { return half_bits(clean_alpha(alpha)); });
  else
    add(&alpha_floats_, rows.floats, 1.0f, [](float alpha) { return float_bits(clean_alpha(alpha)); });
}

PackedImage TexelPacker::take() {
  PackedImage image;
  const Vec2i size(layout_.width, layout_.height);
  const auto alpha_of = [](size_t byte) { return half_bits(static_cast<float>(byte) / 255); };
  // Small images cost less without a palette.
  if (palette_ && bytes_.size() < sizeof(float) * 3 * 256) leave_palette();
  image.is_grey = is_grey_;
  if (storage_ == Storage::floats) {
    image.floats = {size, std::move(floats_), {}};
    if (!alpha_floats_.empty()) image.alpha_floats = {size, std::move(alpha_floats_), {}};
    return image;
  }
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
