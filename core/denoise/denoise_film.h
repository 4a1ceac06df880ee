// The film's AOV `denoised`, made from its color, albedo and normal.
#pragma once

#include <algorithm>

#include "core/denoise/denoiser.h"
#include "core/film/film.h"

namespace alabaster {

/// Denoises the film's color, of which no one may add samples meanwhile, and stores the result. Values that are not
/// finite count as black. Where alpha is 0 the result is 0. Unless it is done, the film stays as it was. Does not
/// throw: a lack of memory is a failure, too.
DenoiseStatus denoise_film(const Denoiser& denoiser, const DenoiseOptions& options, Film* film, std::string* problem);

/// Bytes that this takes for a moment, measured with version 2.5.1, which bounds its own memory.
inline double denoise_bytes(const PixelRect& window) {
  constexpr double kOfTheLibrary = 700, kMost = 3e9, kOfTheFrame = 64;  // the first and the last per pixel
  const double pixels = static_cast<double>(window.width()) * window.height();
  return std::min(kOfTheLibrary * pixels, kMost) + kOfTheFrame * pixels;
}

}  // namespace alabaster
