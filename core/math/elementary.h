// Elementary functions for inner loops: inline, without the library's calls and corner cases, right to a few units of
// the last place of their type. Coefficients: Moshier's Cephes library.
#pragma once

#include <bit>
#include <cmath>
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

struct SineCosineDouble {
  double sine, cosine;
};

/// Sine and cosine of x in [0, 2 pi]; absolute error below 1e-15, and of the sine relative near zero.
inline SineCosineDouble quick_sine_cosine(double angle) {
  const auto quadrant = static_cast<int32_t>(angle * (2 / std::numbers::pi) + 0.5);
  const double x = angle - static_cast<double>(quadrant) * (std::numbers::pi / 2), z = x * x;
  double s = 1.58962301576546568060e-10;
  s = s * z - 2.50507477628578072866e-8;
  s = s * z + 2.75573136213857245213e-6;
  s = s * z - 1.98412698295895385996e-4;
  s = s * z + 8.33333333332211858878e-3;
  s = s * z - 1.66666666666666307295e-1;
  s = s * z * x + x;
  double c = -1.13585365213876817300e-11;
  c = c * z + 2.08757008419747316778e-9;
  c = c * z - 2.75573141792967388112e-7;
  c = c * z + 2.48015872888517045348e-5;
  c = c * z - 1.38888888888730564116e-3;
  c = c * z + 4.16666666666665929218e-2;
  c = c * z * z - 0.5 * z + 1;
  const double a = quadrant & 1 ? c : s, b = quadrant & 1 ? s : c;
  return {quadrant & 2 ? -a : a, (quadrant + 1) & 2 ? -b : b};
}

/// The angle of (x, y), as std::atan2, relative error below 1e-15. Not for the origin, nor where a square would
/// overflow or vanish.
inline double quick_atan2(double y, double x) {
  // Turned by an eighth or a quarter into where the fraction converges.
  const double up = std::abs(y), along = std::abs(x);
  const bool steep = up > 2.414213562373095 * along, diagonal = !steep && up > 0.66 * along;
  const double numerator = steep ? -along : diagonal ? up - along : up;
  const double denominator = steep ? up : diagonal ? up + along : along;
  const double begin = steep ? std::numbers::pi / 2 : diagonal ? std::numbers::pi / 4 : 0;
  const double t = numerator / denominator, z = t * t;
  double p = -8.750608600031904122785e-1;
  p = p * z - 1.615753718733365076637e1;
  p = p * z - 7.500855792314704667340e1;
  p = p * z - 1.228866684490136173410e2;
  p = p * z - 6.485021904942025371773e1;
  double q = z + 2.485846490142306297962e1;
  q = q * z + 1.650270098316988542046e2;
  q = q * z + 4.328810604912902668951e2;
  q = q * z + 4.853903996359136964868e2;
  q = q * z + 1.945506571482613964425e2;
  const double angle = begin + (t * (z * p / q) + t);
  return std::copysign(x < 0 ? std::numbers::pi - angle : angle, y);
}

}  // namespace alabaster
