// Rgb in the rendering space (linear, scene-referred); never a Vec3.
#pragma once

#include <algorithm>
#include <cmath>

namespace alabaster {

struct Rgb {
  float r = 0, g = 0, b = 0;

  Rgb() = default;
  constexpr explicit Rgb(float v) : r(v), g(v), b(v) {}
  constexpr Rgb(float r_, float g_, float b_) : r(r_), g(g_), b(b_) {}

  float operator[](int i) const { return i == 0 ? r : i == 1 ? g : b; }
  float& operator[](int i) { return i == 0 ? r : i == 1 ? g : b; }
  Rgb& operator+=(const Rgb& o) { return r += o.r, g += o.g, b += o.b, *this; }
  Rgb& operator*=(const Rgb& o) { return r *= o.r, g *= o.g, b *= o.b, *this; }
  Rgb& operator*=(float s) { return r *= s, g *= s, b *= s, *this; }
  bool operator==(const Rgb&) const = default;
};

inline Rgb operator+(Rgb a, const Rgb& b) {
  return a += b;
}
inline Rgb operator-(const Rgb& a, const Rgb& b) {
  return {a.r - b.r, a.g - b.g, a.b - b.b};
}
inline Rgb operator*(Rgb a, const Rgb& b) {
  return a *= b;
}
inline Rgb operator*(Rgb a, float s) {
  return a *= s;
}
inline Rgb operator*(float s, Rgb a) {
  return a *= s;
}
inline Rgb lerp(const Rgb& a, const Rgb& b, float t) {
  return a * (1 - t) + b * t;
}
inline float max_component(const Rgb& c) {
  return std::max(c.r, std::max(c.g, c.b));
}
inline bool is_black(const Rgb& c) {
  return c.r == 0 && c.g == 0 && c.b == 0;
}
inline bool is_finite(const Rgb& c) {
  return std::isfinite(c.r) && std::isfinite(c.g) && std::isfinite(c.b);
}

/// A linear map of colours.
struct RgbMatrix {
  Rgb red{1, 0, 0}, green{0, 1, 0}, blue{0, 0, 1};  // its columns
  Rgb operator()(const Rgb& c) const { return red * c.r + green * c.g + blue * c.b; }
};

/// Relative luminance for Rec.709 primaries: used to weigh choices, never to change colour.
inline float luminance(const Rgb& c) {
  return 0.2126f * c.r + 0.7152f * c.g + 0.0722f * c.b;
}

}  // namespace alabaster
