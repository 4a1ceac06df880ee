#include "core/denoise/denoise_film.h"

#include <algorithm>
#include <cmath>
#include <new>

namespace alabaster {
namespace {

float finite(float value) {
  return std::isfinite(value) ? value : 0.0f;
}

DenoiserFrame frame_of(const Film& film, const std::vector<float>& rgba) {
  DenoiserFrame frame{static_cast<size_t>(film.data_window().width()),
                      static_cast<size_t>(film.data_window().height()),
                      {},
                      film.resolve_float(Aov::albedo),
                      film.resolve_float(Aov::normal)};
  frame.color.reserve(rgba.size() / 4 * 3);
  for (size_t i = 0; i < rgba.size(); i += 4)
    for (size_t c = 0; c < 3; ++c) frame.color.push_back(finite(rgba[i + c]));
  for (float& v : frame.albedo) v = std::clamp(finite(v), 0.0f, 1.0f);
  for (float& v : frame.normal) v = finite(v);
  return frame;
}

// Open Image Denoise takes light below 1e-8 for black: a picture is denoised at a geometric mean of about 1, which few
// bright pixels do not move. A power of two changes no digit.
int exponent_of(const std::vector<float>& color) {
  constexpr int kRoom = 60;  // of the brightest
  double logarithms = 0;
  size_t lit = 0;
  float largest = 0;
  for (const float v : color) {
    if (!(v > 0)) continue;
    logarithms += std::log2(double(v));
    largest = std::max(largest, v);
    ++lit;
  }
  return lit ? std::max(int(std::floor(logarithms / double(lit))), std::ilogb(largest) - kRoom) : 0;
}

}  // namespace

DenoiseStatus denoise_film(const Denoiser& denoiser, const DenoiseOptions& options, Film* film, std::string* problem) {
  try {
    const std::vector<float> rgba = film->resolve_float(Aov::color);
    DenoiserFrame frame = frame_of(*film, rgba);
    const int exponent = exponent_of(frame.color);
    for (float& v : frame.color) v = std::ldexp(v, -exponent);
    const DenoiseStatus status = denoiser.denoise(&frame, options, problem);
    if (status != DenoiseStatus::done) return status;
    for (float& v : frame.color) v = std::ldexp(v, exponent);
    for (size_t i = 0; i < rgba.size() / 4; ++i)
      if (!(rgba[4 * i + 3] > 0)) std::fill_n(frame.color.begin() + static_cast<std::ptrdiff_t>(3 * i), 3, 0.0f);
    if (!std::all_of(frame.color.begin(), frame.color.end(), [](float v) { return std::isfinite(v); })) {
      *problem = "its picture has values that are not finite";
      return DenoiseStatus::failed;
    }
    film->store_denoised(std::move(frame.color));
    return DenoiseStatus::done;
  } catch (const std::bad_alloc&) {
    *problem = "there is not enough memory";
    return DenoiseStatus::failed;
  }
}

}  // namespace alabaster
