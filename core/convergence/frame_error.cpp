#include "core/convergence/frame_error.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace alabaster {
namespace {

using Levels = std::vector<double>;

struct Size {
  int width, height;
};

/// Mean of the 3 x 3 pixels around (x, y). The pixel's own level counts at most as much as its brightest neighbour's,
/// since a sample that found much light by chance must not excuse the noise that it is.
double local_level(const Levels& levels, const Size& size, int x, int y) {
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
  return (sum + (count > 0 ? std::min(own, brightest) : own)) / (count + 1);
}

/// L^2 + f^2 of every pixel; empty if the frame is black.
std::vector<double> squared_scales(const Levels& levels, const Size& size) {
  double mean = 0;
  for (double level : levels) mean += level / double(levels.size());
  if (!(mean > 0)) return {};
  const double floor = kErrorFloor * mean;
  std::vector<double> scales(levels.size());
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      const double level = local_level(levels, size, x, y);
      scales[size_t(y) * size_t(size.width) + size_t(x)] = level * level + floor * floor;
    }
  return scales;
}

// Variance of the mean of x m samples: a / x + b / x^2, or x^-exponent where a smooth integrand has the frame for
// itself, in units where V(1/2) - V(1) = 1 (frame_error.md, "The law of convergence"; Owen 1997).
struct ConvergenceLaw {
  double a = 1;                  // noise
  double b_even = 0, b_odd = 0;  // what stratification leaves, at even and odd powers of two from m
  double exponent = 0;           // 0: the sum

  /// The part of V(1) that is not noise, 0..1.
  double stratified() const {
    return exponent > 0 ? 1 : std::clamp(std::abs(b_even) / (a + std::abs(b_even)), 0.0, 1.0);
  }
  double variance(double x) const {
    if (exponent > 0) return std::pow(x, -exponent) / (std::exp2(exponent) - 1);
    const bool even = std::lround(std::log2(x)) % 2 == 0;
    return a / x + (even ? b_even : b_odd) / (x * x);
  }
};

// The first samples of a pixel. All aligned blocks of 2^k samples have the same distribution.
struct SampleTree {
  ConvergenceLaw law;
  double m = 1;  // samples at which the law has x = 1

  double variance(double samples) const { return law.variance(samples / m); }
  // Covariance of two samples whose indices first differ in the bit of `block`.
  double covariance(double block) const { return 2 * variance(2 * block) - variance(block); }
  // Variance of the sum of the first n: that of a whole block, that of the rest, and twice their covariance.
  double sum_variance(uint32_t n) const {
    if (n == 0) return 0;
    const uint32_t block = std::bit_floor(n), rest = n - block;
    return double(block) * block * variance(block) + sum_variance(rest) + 2.0 * block * rest * covariance(block);
  }
};

// Variance of the mean of n samples over the expectation of PixelNoise::difference().
double variance_per_difference(uint32_t n, const ConvergenceLaw& law) {
  const uint32_t m = std::bit_floor(n), rest = n - m;
  const SampleTree tree{law, double(m)};
  const double variance = tree.sum_variance(n) / (double(n) * n);
  if (!PixelNoise::uses_tail(n)) return variance / 4;
  return variance / (tree.variance(m) + tree.sum_variance(rest) / (double(rest) * rest) - 2 * tree.covariance(m));
}

// One number for each of the differences that a pixel records.
struct PerDifference {
  double latest = 0, previous = 0, earlier = 0;
};

struct Convergence {
  ConvergenceLaw law;
  PerDifference means;                // over the frame
  PerDifference elasticity{1, 0, 0};  // d ln V(1) / d ln of each mean
};

// Two differences: latest = a + 3 b and previous = 2 a + 12 b. `previous` in units of the latest.
void fit_one_b(double previous, Convergence* c) {
  const double b = (previous - 2) / 6, variance = (5 - previous) / 3;
  c->law = {.a = (4 - previous) / 2, .b_even = b, .b_odd = b};
  c->elasticity = {5.0 / 3 / variance, -previous / 3 / variance, 0};
}

// Three differences, in units of the latest: a + 4 o - e, 2 a + 16 e - 4 o and 4 a + 64 o - 16 e, with e = b_even and
// o = b_odd.
void fit_two_b(double previous, double earlier, Convergence* c) {
  if (earlier > 16) {  // a < 0: the variance falls faster than the sum can
    const double growth = std::sqrt(earlier);
    c->law.exponent = std::log2(growth);
    c->elasticity.earlier = -0.5 * growth / (growth - 1);
    c->elasticity.latest = 1 - c->elasticity.earlier;
    return;
  }
  const double a = (16 - earlier) / 12, e = (1 + previous - 3 * a) / 15;
  c->law = {.a = a, .b_even = e, .b_odd = (1 - a + e) / 4};
  c->elasticity = {17.0 / 15 / (a + e), previous / 15 / (a + e), -earlier / 15 / (a + e)};
}

// One law for the whole frame, since the ratios of one pixel are noise.
Convergence fit_convergence(const std::vector<PixelNoise>& pixels, const std::vector<double>& scales) {
  Convergence c;
  PerDifference& means = c.means;
  uint32_t least = pixels.front().samples;
  const auto n = double(pixels.size());
  for (size_t i = 0; i < pixels.size(); ++i) {
    least = std::min(least, pixels[i].samples);
    means.latest += pixels[i].latest / scales[i] / n;
    means.previous += pixels[i].previous / scales[i] / n;
    means.earlier += pixels[i].earlier / scales[i] / n;
  }
  // A difference of zero does not show how the variance falls.
  if (!(means.latest > 0)) return {};
  if (!(means.previous > 0)) least = std::min(least, 3u);
  if (!(means.earlier > 0)) least = std::min(least, 7u);
  if (least < 4) return {};
  // Beyond these bounds there is only chance: independent samples have 2 and 4, a smooth integrand of one dimension 8
  // and 64.
  const double previous = std::clamp(means.previous / means.latest, 1.0, least < 8 ? 4.0 : 8.0);
  if (least < 8)
    fit_one_b(previous, &c);
  else
    fit_two_b(previous, std::clamp(means.earlier / means.latest, 2.0, 64.0), &c);
  return c;
}

// L^2 + f^2 of every pixel, and the variance of each pixel's mean over that.
struct RelativeErrors {
  std::vector<double> scales, values;
  Convergence convergence;
};

bool all_have_two_samples(const NoiseImage& image) {
  return !image.pixels.empty() &&
         std::all_of(image.pixels.begin(), image.pixels.end(), [](const PixelNoise& p) { return p.samples >= 2; });
}

// Empty if the frame is black.
RelativeErrors relative_errors(const NoiseImage& image) {
  const auto& pixels = image.pixels;
  RelativeErrors errors;
  Levels levels(pixels.size());
  for (size_t i = 0; i < pixels.size(); ++i) levels[i] = pixels[i].level;
  errors.scales = squared_scales(levels, {image.width, image.height});
  if (errors.scales.empty()) return errors;
  errors.convergence = fit_convergence(pixels, errors.scales);
  errors.values.resize(pixels.size());
  std::vector<double> factors;  // by number of samples; 0: not computed yet
  for (size_t i = 0; i < pixels.size(); ++i) {
    const uint32_t n = pixels[i].samples;
    if (n >= factors.size()) factors.resize(2 * size_t(n));
    if (factors[n] == 0) factors[n] = variance_per_difference(n, errors.convergence.law);
    errors.values[i] = factors[n] * pixels[i].difference() / errors.scales[i];
  }
  return errors;
}

// Variance of ln E^2 (frame_error.md, "The interval"): the estimate's scatter over pixels, that of the true error, and
// the doubt about the law.
double log_variance(const std::vector<PixelNoise>& pixels, const RelativeErrors& errors, double mean) {
  constexpr double kNoiseDoubt = 0.05, kStratifiedDoubt = 0.5;
  const auto& [law, means, elasticity] = errors.convergence;
  const double doubt = kNoiseDoubt + kStratifiedDoubt * law.stratified();
  const auto part = [](double weight, float difference, double scale, double mean_difference) {
    return mean_difference > 0 ? weight * (difference / scale / mean_difference - 1) : 0.0;
  };
  double truth = 0, estimate = 0;
  for (size_t i = 0; i < pixels.size(); ++i) {
    const double scale = errors.scales[i];
    const double d = errors.values[i] / mean - 1;
    const double e = d + part(elasticity.latest - 1, pixels[i].latest, scale, means.latest) +
                     part(elasticity.previous, pixels[i].previous, scale, means.previous) +
                     part(elasticity.earlier, pixels[i].earlier, scale, means.earlier);
    truth += d * d;
    estimate += e * e;
  }
  const auto n = double(pixels.size());
  return (truth + estimate) / std::max(1.0, n - 1) / n + doubt * doubt;
}

}  // namespace

FrameError estimate_frame_error(const NoiseImage& image) {
  FrameError error;
  if (!all_have_two_samples(image)) return error;
  const RelativeErrors errors = relative_errors(image);
  error.known = true;
  double mean = 0;
  for (const double value : errors.values) mean += value / double(errors.values.size());
  if (!(mean > 0)) return error;  // a black frame, for example: without light there is no noise
  const double reach = 1.96 * std::sqrt(log_variance(image.pixels, errors, mean));
  error.relative_rmse = std::sqrt(mean);
  error.low = std::sqrt(mean * std::exp(-reach));
  error.high = std::sqrt(mean * std::exp(reach));
  return error;
}

std::vector<double> relative_squared_errors(const NoiseImage& image) {
  return all_have_two_samples(image) ? relative_errors(image).values : std::vector<double>();
}

NoiseImage film_noise(const Film& film) {
  const PixelRect& window = film.data_window();
  if (window.empty()) return {};
  return {window.width(), window.height(), film.noise()};
}

FrameError estimate_frame_error(const Film& film) {
  return estimate_frame_error(film_noise(film));
}

size_t frame_error_bytes(const PixelRect& window) {
  if (window.empty()) return 0;
  constexpr size_t kPixel = sizeof(PixelNoise) + 3 * sizeof(double);  // levels, scales, values
  return kPixel * size_t(window.width()) * size_t(window.height());
}

uint32_t samples_for_error(uint32_t done, uint32_t most, double error, double target) {
  const double ratio = error / target;
  return uint32_t(std::clamp(std::ceil(done * ratio * ratio), 1.0, double(most)));
}

}  // namespace alabaster
