#include "core/film/frame_error.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>

namespace alabaster {
namespace {

using Levels = std::vector<double>;

struct Size {
  int width, height;
};

/// Mean of the 3 x 3 pixels about (x, y). `clip`: the pixel's own level counts up to the brightest of its neighbours:
/// a sample that found much light by chance must not excuse the noise that it is.
double local_level(const Levels& levels, const Size& size, int x, int y, bool clip) {
  double sum = 0, brightest = 0;
  int count = 0;
  for (int ny = std::max(0, y - 1); ny <= std::min(size.height - 1, y + 1); ++ny)
    for (int nx = std::max(0, x - 1); nx <= std::min(size.width - 1, x + 1); ++nx) {
      if (nx == x && ny == y) continue;
      const double level = levels[size_t(ny) * size_t(size.width) + size_t(nx)];
      sum += level;
      brightest = std::max(brightest, level);
      ++count;
    }
  const double own = levels[size_t(y) * size_t(size.width) + size_t(x)];
  return (sum + (clip && count > 0 ? std::min(own, brightest) : own)) / (count + 1);
}

/// L^2 + f^2 of every pixel; empty if the frame is black.
std::vector<double> squared_scales(const Levels& levels, const Size& size, bool clip) {
  double mean = 0;
  for (double level : levels) mean += level / double(levels.size());
  if (!(mean > 0)) return {};
  const double floor = kErrorFloor * mean;
  std::vector<double> scales(levels.size());
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      const double level = local_level(levels, size, x, y, clip);
      scales[size_t(y) * size_t(size.width) + size_t(x)] = level * level + floor * floor;
    }
  return scales;
}

// V(m) = m^-p for all powers of two m; the covariances at the head of frame_error.h follow from it.
struct PowerLaw {
  double p = 1;

  double variance(double m) const { return std::pow(m, -p); }
  // Of two samples whose indices first differ in the bit of m.
  double covariance(double m) const { return 2 * variance(2 * m) - variance(m); }
  // Of the sum of the first n samples: a whole block, the rest, and twice what they share.
  double sum_variance(uint32_t n) const {
    if (n == 0) return 0;
    const uint32_t block = std::bit_floor(n), rest = n - block;
    return double(block) * block * variance(block) + sum_variance(rest) + 2.0 * block * rest * covariance(block);
  }
};

// The tail tells more than the halves before it once it is half as long.
bool uses_tail(uint32_t n) {
  const uint32_t m = std::bit_floor(n);
  return n - m >= (m + 1) / 2 && n > m;
}

// Variance of the mean of n samples over the expected squared difference that noise_of() gives.
double variance_per_difference(uint32_t n, const PowerLaw& law) {
  const double variance = law.sum_variance(n) / (double(n) * n);
  const uint32_t m = std::bit_floor(n), rest = n - m;
  if (!uses_tail(n)) return variance / (4 * (law.variance(m / 2) - law.variance(m)));
  const double expected = law.variance(m) + law.sum_variance(rest) / (double(rest) * rest) - 2 * law.covariance(m);
  return variance / expected;
}

double difference_of(const PixelNoise& noise) {
  return uses_tail(noise.samples) ? noise.tail : noise.latest;
}

struct Exponent {
  double p = 1;
  double trust = 0;                 // 0: p = 1 is assumed; 1: p is measured
  double previous = 0, latest = 0;  // means of the differences that it was measured from
};

// From the frame's differences at two sizes, (V(m/4) - V(m/2)) / (V(m/2) - V(m)) = 2^p. A ratio that its own scatter
// explains says nothing: it is drawn to p = 1 by as much as noise has to do with it.
Exponent measure_exponent(const std::vector<PixelNoise>& pixels, const std::vector<double>& scales) {
  Exponent e;
  const auto n = double(pixels.size());
  for (size_t i = 0; i < pixels.size(); ++i) {
    if (pixels[i].samples < 4) return {};
    e.previous += pixels[i].previous / scales[i] / n;
    e.latest += pixels[i].latest / scales[i] / n;
  }
  if (!(e.latest > 0)) return {};
  constexpr double kLeast = 1.5, kSteepest = 8;  // p = 3: smooth, one dimension
  const double ratio = std::log(std::clamp(e.previous / e.latest, kLeast, kSteepest) / 2);
  if (ratio == 0) return e;
  double squares = 0;
  for (size_t i = 0; i < pixels.size(); ++i) {
    const double d = (pixels[i].previous / e.previous - pixels[i].latest / e.latest) / scales[i];
    squares += d * d / (n * n);
  }
  e.trust = ratio * ratio / (ratio * ratio + squares);
  e.p = 1 + e.trust * ratio / std::log(2.0);
  return e;
}

}  // namespace

namespace {

struct Terms {
  std::vector<double> scales, values;  // L^2 + f^2, and the variance over it, of every pixel
  Exponent exponent;
};

bool all_have_two_samples(const NoiseImage& image) {
  return !image.pixels.empty() &&
         std::all_of(image.pixels.begin(), image.pixels.end(), [](const PixelNoise& p) { return p.samples >= 2; });
}

Terms make_terms(const NoiseImage& image) {
  const auto& pixels = image.pixels;
  Terms t;
  Levels levels(pixels.size());
  for (size_t i = 0; i < pixels.size(); ++i) levels[i] = pixels[i].level;
  t.scales = squared_scales(levels, {image.width, image.height}, true);
  if (t.scales.empty()) return t;
  t.exponent = measure_exponent(pixels, t.scales);
  t.values.resize(pixels.size());
  std::map<uint32_t, double> factors;
  for (size_t i = 0; i < pixels.size(); ++i) {
    double& factor = factors[pixels[i].samples];
    if (factor == 0) factor = variance_per_difference(pixels[i].samples, {t.exponent.p});
    t.values[i] = factor * difference_of(pixels[i]) / t.scales[i];
  }
  return t;
}

// Variance of ln E^2 by the scatter over pixels, twice: of what the estimate is made of, the exponent's part included
// (E^2 goes as 1 / (2^p - 1)), and of the frame's own error, which scatters about its expectation as much as the terms
// and independently of them (a - b and a + b are uncorrelated). Third, what the power law is not sure of.
double log_variance(const std::vector<PixelNoise>& pixels, const Terms& t, double mean) {
  constexpr double kLaw = 0.05;
  const double growth = std::pow(2, t.exponent.p);
  const double by_exponent = t.exponent.trust * growth / (growth - 1);
  double own = 0, estimate = 0;
  for (size_t i = 0; i < pixels.size(); ++i) {
    const double d = t.values[i] / mean - 1;
    double e = d;
    if (by_exponent > 0)
      e +=
          by_exponent * (pixels[i].latest / t.exponent.latest - pixels[i].previous / t.exponent.previous) / t.scales[i];
    own += d * d;
    estimate += e * e;
  }
  const auto n = double(pixels.size());
  return (own + estimate) / std::max(1.0, n - 1) / n + kLaw * kLaw;
}

}  // namespace

FrameError estimate_frame_error(const NoiseImage& image) {
  FrameError error;
  if (!all_have_two_samples(image)) return error;
  const Terms t = make_terms(image);
  error.known = true;
  double mean = 0;
  for (const double value : t.values) mean += value / double(t.values.size());
  if (!(mean > 0)) return error;  // a black frame, for example: without light there is no noise
  const double reach = 1.96 * std::sqrt(log_variance(image.pixels, t, mean));
  error.exponent = t.exponent.p;
  error.relative_rmse = std::sqrt(mean);
  error.low = std::sqrt(mean * std::max(0.0, 1 - reach));
  error.high = std::sqrt(mean * (1 + reach));
  return error;
}

std::vector<double> relative_squared_errors(const NoiseImage& image) {
  return all_have_two_samples(image) ? make_terms(image).values : std::vector<double>();
}

FrameError estimate_frame_error(const Film& film) {
  const PixelRect& window = film.data_window();
  if (window.empty()) return {};
  return estimate_frame_error({window.width(), window.height(), film.noise()});
}

float pixel_deviation(const PixelNoise& noise) {
  if (noise.samples < 2) return 0;
  return float(std::sqrt(variance_per_difference(noise.samples, {}) * difference_of(noise)));
}

double relative_mse(const std::vector<float>& image, const std::vector<float>& reference, int width, int height) {
  std::vector<double> levels(reference.size() / 4);
  for (size_t i = 0; i < levels.size(); ++i)
    levels[i] = (double(reference[4 * i]) + double(reference[4 * i + 1]) + double(reference[4 * i + 2])) / 3;
  const auto scales = squared_scales(levels, {width, height}, false);
  double sum = 0;
  for (size_t i = 0; i < scales.size(); ++i) {
    double squared = 0;
    for (size_t c = 0; c < 3; ++c) squared += std::pow(double(image[4 * i + c]) - double(reference[4 * i + c]), 2) / 3;
    sum += squared / scales[i];
  }
  return scales.empty() ? 0 : sum / double(scales.size());
}

}  // namespace alabaster
