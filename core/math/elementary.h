// Elementary functions for inner loops: inline, without the library's calls and corner cases, right to a few units of
// the last place of a float. Coefficients: Moshier's Cephes library.
#pragma once

#include <bit>
#include <cstdint>
#include <numbers>

namespace alabaster {

/// exp(x) for x <= 88, relative error below 2e-7; 0 below -87.
inline float quick_exp(float x) {
  if (!(x > -87.0f)) return 0;
  // Adding 1.5 2^23 rounds to a whole number.
  const float n = (x * 1.44269504f + 12582912.0f) - 12582912.0f;
  const float r = (x - n * 0.693359375f) + n * 2.12194440e-4f;
  float p = 1.9875691500e-4f;
  p = p * r + 1.3981999507e-3f;
  p = p * r + 8.3334519073e-3f;
  p = p * r + 4.1665795894e-2f;
  p = p * r + 1.6666665459e-1f;
  p = p * r + 5.0000001201e-1f;
  const float power = std::bit_cast<float>((static_cast<int32_t>(n) + 127) << 23);
  return (p * r * r + r + 1) * power;
}

struct SineCosine {
  float sine, cosine;
};

/// Sine and cosine of 2 pi u, u in [0,1]; absolute error below 2e-7.
inline SineCosine quick_sine_cosine_turns(float u) {
  const auto quadrant = static_cast<int32_t>(u * 4 + 0.5f);
  const float x = (u - static_cast<float>(quadrant) * 0.25f) * (2 * std::numbers::pi_v<float>), x2 = x * x;
  const float s = ((-1.9515295891e-4f * x2 + 8.3321608736e-3f) * x2 - 1.6666654611e-1f) * x2 * x + x;
  const float c =
      ((2.443315711809948e-5f * x2 - 1.388731625493765e-3f) * x2 + 4.166664568298827e-2f) * x2 * x2 - 0.5f * x2 + 1;
  const float a = quadrant & 1 ? c : s, b = quadrant & 1 ? s : c;
  return {quadrant & 2 ? -a : a, (quadrant + 1) & 2 ? -b : b};
}

}  // namespace alabaster
