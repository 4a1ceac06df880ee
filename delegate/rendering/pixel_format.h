// Values of the film -> pixels of a host's buffer.
#pragma once

#include <span>

#include "core/film/film.h"
#include "delegate/api/scene_types.h"

namespace alabaster::hd::rendering {

/// Converts pixels of `components` values each. Components that the AOV lacks become 0, a fourth 1. int -> float is a
/// cast, float -> int rounds; unorm clamps to 0..1; not-a-number becomes 0 in unorm and int.
void write_pixels(std::span<const float> values, size_t components, Format format, uint8_t* pixels);
void write_pixels(std::span<const int32_t> values, Format format, uint8_t* pixels);  // of one value each

/// Reads pixels as four floats each, the inverse of write_pixels but for rounding: components that the format lacks are
/// 0, a fourth 1.
void read_pixels(const uint8_t* pixels, Format format, std::span<float> rgba);

/// `clear` as one pixel of `format`: components of a number or a vector.
void write_clear(const Value& clear, Format format, uint8_t* pixel);

/// Format, clear value; format invalid for an AOV that is not supported.
AovDescriptor default_aov_descriptor(const Token& aov);

}  // namespace alabaster::hd::rendering
