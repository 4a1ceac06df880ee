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

// How the variance of the mean falls with the number of samples, in units of what the latest halves show:
// V(m/2) - V(m) = 1, where x = 1 stands for m samples. `ratio` is that difference at half as many samples over this
// one, (V(m/4) - V(m/2)) / (V(m/2) - V(m)): 2 for independent samples. Up to 4 the law is a / x + b / x^2, noise
// together with what stratification takes away, in which V(1) = (5 - ratio) / 3 is linear in the differences, so that a
// mixture of pixels is as good as one; beyond, where a smooth integrand has the frame for itself, x^-p with 2^p =
// ratio. At 4 they agree.
struct ConvergenceLaw {
  double ratio = 2;

  double variance(double x) const {
    if (ratio <= 4) return (4 - ratio) / 2 / x + (ratio - 2) / 6 / (x * x);
    return std::pow(x, -std::log2(ratio)) / (ratio - 1);
  }
  // d ln V(1) / d ln ratio, positive for falling.
  double sensitivity() const { return ratio / (ratio <= 4 ? 5 - ratio : ratio - 1); }
};

// The first samples of a pixel whose latest halves have m samples together.
struct SampleTree {
  ConvergenceLaw law;
  double m = 1;

  double variance(double samples) const { return law.variance(samples / m); }
  // Of two samples whose indices first differ in the bit of `block`.
  double covariance(double block) const { return 2 * variance(2 * block) - variance(block); }
  // Of the sum of the first n: a whole block, the rest, and twice what they share.
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

// Variance of the mean of n samples over the expected squared difference that difference_of() gives.
double variance_per_difference(uint32_t n, const ConvergenceLaw& law) {
  const uint32_t m = std::bit_floor(n), rest = n - m;
  const SampleTree tree{law, double(m)};
  const double variance = tree.sum_variance(n) / (double(n) * n);
  if (!uses_tail(n)) return variance / 4;
  return variance / (tree.variance(m) + tree.sum_variance(rest) / (double(rest) * rest) - 2 * tree.covariance(m));
}

double difference_of(const PixelNoise& noise) {
  return uses_tail(noise.samples) ? noise.tail : noise.latest;
}

struct Convergence {
  ConvergenceLaw law;
  double previous = 0, latest = 0;  // means of the differences that it was measured from; 0: it is assumed
};

// From the whole frame: a pixel's own ratio is noise.
Convergence measure_convergence(const std::vector<PixelNoise>& pixels, const std::vector<double>& scales) {
  Convergence c;
  for (size_t i = 0; i < pixels.size(); ++i) {
    if (pixels[i].samples < 4) return {};
    c.previous += pixels[i].previous / scales[i] / double(pixels.size());
    c.latest += pixels[i].latest / scales[i] / double(pixels.size());
  }
  if (!(c.latest > 0)) return {};
  constexpr double kLeast = 1.5, kLargest = 8;  // chance; a smooth integrand of one dimension
  c.law.ratio = std::clamp(c.previous / c.latest, kLeast, kLargest);
  return c;
}

}  // namespace

namespace {

struct Terms {
  std::vector<double> scales, values;  // L^2 + f^2, and the variance over it, of every pixel
  Convergence convergence;
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
  t.convergence = measure_convergence(pixels, t.scales);
  t.values.resize(pixels.size());
  std::map<uint32_t, double> factors;
  for (size_t i = 0; i < pixels.size(); ++i) {
    double& factor = factors[pixels[i].samples];
    if (factor == 0) factor = variance_per_difference(pixels[i].samples, t.convergence.law);
    t.values[i] = factor * difference_of(pixels[i]) / t.scales[i];
  }
  return t;
}

// Variance of ln E^2 by the scatter over pixels, twice: of what the estimate is made of, the ratio's part included, and
// of the frame's own error, which scatters about its expectation as much as the terms and independently of them (a - b
// and a + b are uncorrelated). Third, what the law is not sure of.
double log_variance(const std::vector<PixelNoise>& pixels, const Terms& t, double mean) {
  constexpr double kLaw = 0.05;
  const Convergence& c = t.convergence;
  const double by_ratio = c.latest > 0 && c.previous > 0 ? c.law.sensitivity() : 0;
  double own = 0, estimate = 0;
  for (size_t i = 0; i < pixels.size(); ++i) {
    const double d = t.values[i] / mean - 1;
    double e = d;
    if (by_ratio > 0) e += by_ratio * (pixels[i].latest / c.latest - pixels[i].previous / c.previous) / t.scales[i];
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
  error.exponent = std::log2(t.convergence.law.ratio);
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
