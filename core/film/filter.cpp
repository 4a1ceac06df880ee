#include "core/film/filter.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace alabaster {
namespace {

// Tabulated inverse of the cumulative distribution of a filter over [-radius, radius], for filters without a closed
// form.
class InverseCdf {
 public:
  template <class Filter>
  InverseCdf(float radius, const Filter& filter) {
    constexpr int kSteps = 1 << 14;
    const double step = 2.0 * radius / kSteps;
    double total = 0;
    for (int i = 0; i < kSteps; ++i) total += filter(-radius + (i + 0.5) * step);
    double running = 0;
    size_t next = 0;
    for (int i = 0; i < kSteps; ++i) {
      const double density = filter(-radius + (i + 0.5) * step) / total;
      // Invert linearly within the step.
      while (next < table_.size() && static_cast<double>(next) / (kSize - 1) <= running + density) {
        const double part = density > 0 ? (static_cast<double>(next) / (kSize - 1) - running) / density : 0;
        table_[next++] = static_cast<float>(-radius + (i + part) * step);
      }
      running += density;
    }
    std::fill(table_.begin() + static_cast<std::ptrdiff_t>(next), table_.end(), radius);
  }
  float operator()(float u) const {
    const float x = u * (kSize - 1);
    const auto i = std::min(static_cast<size_t>(x), static_cast<size_t>(kSize - 2));
    return lerp(table_[i], table_[i + 1], x - static_cast<float>(i));
  }

 private:
  static constexpr int kSize = 1025;
  std::array<float, kSize> table_{};
};

float sample_gaussian(float u) {
  static const InverseCdf inverse(1.5f, [](double x) { return std::exp(-x * x / (2 * 0.5 * 0.5)); });
  return inverse(u);
}

// Harris 1978, four-term minimum Blackman-Harris window.
float sample_blackman_harris(float u) {
  static const InverseCdf inverse(1.5f, [](double x) {
    const double t = 2 * kPiDouble * (x / 3 + 0.5);
    return 0.35875 - 0.48829 * std::cos(t) + 0.14128 * std::cos(2 * t) - 0.01168 * std::cos(3 * t);
  });
  return inverse(u);
}

float sample_triangle(float u) {
  return u < 0.5f ? std::sqrt(2 * u) - 1 : 1 - std::sqrt(std::max(0.0f, 2 * (1 - u)));
}

}  // namespace

Vec2f sample_pixel_filter(PixelFilter filter, const Vec2f& u) {
  switch (filter) {
    case PixelFilter::box:
      return {u.x - 0.5f, u.y - 0.5f};
    case PixelFilter::triangle:
      return {sample_triangle(u.x), sample_triangle(u.y)};
    case PixelFilter::gaussian:
      return {sample_gaussian(u.x), sample_gaussian(u.y)};
    case PixelFilter::blackman_harris:
      return {sample_blackman_harris(u.x), sample_blackman_harris(u.y)};
  }
  return {0, 0};
}

}  // namespace alabaster
