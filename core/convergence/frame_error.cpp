#include "core/convergence/frame_error.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>

#include "core/convergence/pixel_loop.h"

namespace alabaster {
namespace {

double squared(float x) {
  return double(x) * double(x);
}

/// Mean of the 3 x 3 pixels around (x, y). The pixel's own level counts at most as much as its brightest neighbour's,
/// since a sample that found much light by chance must not excuse the noise that it is.
double local_level(const NoiseImage& image, int x, int y) {
  const auto level = [&](int nx, int ny) -> double {
    return image.pixels[size_t(ny) * size_t(image.width) + size_t(nx)].level;
  };
  double sum = 0, brightest = 0;
  int count = 0;
  for (int ny = std::max(0, y - 1); ny <= std::min(image.height - 1, y + 1); ++ny)
    for (int nx = std::max(0, x - 1); nx <= std::min(image.width - 1, x + 1); ++nx) {
      if (nx == x && ny == y) continue;
      sum += level(nx, ny);
      brightest = std::max(brightest, level(nx, ny));
      ++count;
    }
  const double own = level(x, y);
  return (sum + (count > 0 ? std::min(own, brightest) : own)) / (count + 1);
}

/// L^2 + f^2 of every pixel; empty if the frame is black.
std::vector<double> squared_scales(const NoiseImage& image, const CancelToken& cancel) {
  const size_t n = image.pixels.size();
  const auto mean = sum_over_pixels<double>(
      n, [&](size_t i, double* sum) { *sum += double(image.pixels[i].level) / double(n); }, cancel);
  if (!(mean > 0)) return {};
  const double floor = kErrorFloor * mean;
  std::vector<double> scales(n);
  for_pixel_blocks(
      n,
      [&](size_t, size_t begin, size_t end) {
        const auto width = size_t(image.width);
        for (size_t i = begin; i < end; ++i) {
          const double level = local_level(image, int(i % width), int(i / width));
          scales[i] = level * level + floor * floor;
        }
      },
      cancel);
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

// Variance of the mean of n samples over the expectation of the square of PixelNoise::difference().
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
  void operator+=(const PerDifference& o) {
    latest += o.latest;
    previous += o.previous;
    earlier += o.earlier;
  }
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

// Least and most samples of a pixel.
struct SampleExtremes {
  uint32_t least = ~0u, most = 0;
  void operator+=(const SampleExtremes& o) {
    least = std::min(least, o.least);
    most = std::max(most, o.most);
  }
};

SampleExtremes samples_of(const std::vector<PixelNoise>& pixels, const CancelToken& cancel) {
  return sum_over_pixels<SampleExtremes>(
      pixels.size(),
      [&](size_t i, SampleExtremes* all) {
        *all += {pixels[i].samples, pixels[i].samples};
      },
      cancel);
}

// One law for the whole frame, since the ratios of one pixel are noise.
Convergence fit_convergence(const std::vector<PixelNoise>& pixels, const std::vector<double>& scales, uint32_t least,
                            const CancelToken& cancel) {
  Convergence c;
  const auto n = double(pixels.size());
  c.means = sum_over_pixels<PerDifference>(
      pixels.size(),
      [&](size_t i, PerDifference* sum) {
        *sum += {squared(pixels[i].latest) / scales[i] / n, squared(pixels[i].previous) / scales[i] / n,
                 squared(pixels[i].earlier) / scales[i] / n};
      },
      cancel);
  const PerDifference& means = c.means;
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

// `samples`: two at least. Empty if the frame is black.
RelativeErrors relative_errors(const NoiseImage& image, const SampleExtremes& samples, const CancelToken& cancel) {
  const auto& pixels = image.pixels;
  RelativeErrors errors;
  errors.scales = squared_scales(image, cancel);
  if (errors.scales.empty()) return errors;
  errors.convergence = fit_convergence(pixels, errors.scales, samples.least, cancel);
  errors.values.resize(pixels.size());
  std::vector<std::atomic<double>> factors(size_t(samples.most) + 1);  // by number of samples; 0: not computed yet
  for_pixel_blocks(
      pixels.size(),
      [&](size_t, size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
          std::atomic<double>& shared = factors[pixels[i].samples];
          double factor = shared.load(std::memory_order_relaxed);
          if (factor == 0) shared = factor = variance_per_difference(pixels[i].samples, errors.convergence.law);
          errors.values[i] = factor * squared(pixels[i].difference()) / errors.scales[i];
        }
      },
      cancel);
  return errors;
}

// Variance of ln E^2 (frame_error.md, "The interval"): the estimate's scatter over pixels, that of the true error, and
// the doubt about the law.
double log_variance(const std::vector<PixelNoise>& pixels, const RelativeErrors& errors, double mean,
                    const CancelToken& cancel) {
  constexpr double kNoiseDoubt = 0.05, kStratifiedDoubt = 0.5;
  const ConvergenceLaw& law = errors.convergence.law;
  const PerDifference &means = errors.convergence.means, &elasticity = errors.convergence.elasticity;
  const double doubt = kNoiseDoubt + kStratifiedDoubt * law.stratified();
  const auto part = [](double weight, float difference, double scale, double mean) {
    return mean > 0 ? weight * (squared(difference) / scale / mean - 1) : 0.0;
  };
  struct Squares {
    double truth = 0, estimate = 0;
    void operator+=(const Squares& o) {
      truth += o.truth;
      estimate += o.estimate;
    }
  };
  const auto sum = sum_over_pixels<Squares>(
      pixels.size(),
      [&](size_t i, Squares* squares) {
        const double scale = errors.scales[i];
        const double d = errors.values[i] / mean - 1;
        const double e = d + part(elasticity.latest - 1, pixels[i].latest, scale, means.latest) +
                         part(elasticity.previous, pixels[i].previous, scale, means.previous) +
                         part(elasticity.earlier, pixels[i].earlier, scale, means.earlier);
        *squares += {d * d, e * e};
      },
      cancel);
  const auto n = double(pixels.size());
  return (sum.truth + sum.estimate) / std::max(1.0, n - 1) / n + doubt * doubt;
}

}  // namespace

FrameError estimate_frame_error(const NoiseImage& image, const CancelToken& cancel) {
  FrameError error;
  const SampleExtremes samples = samples_of(image.pixels, cancel);
  if (image.pixels.empty() || samples.least < 2) return error;
  const RelativeErrors errors = relative_errors(image, samples, cancel);
  error.known = true;
  const size_t n = errors.values.size();
  const auto mean = sum_over_pixels<double>(
      n, [&](size_t i, double* sum) { *sum += errors.values[i] / double(n); }, cancel);
  if (!std::isfinite(mean)) return {.known = false, .relative_rmse = mean};
  if (!(mean > 0)) return error;  // a black frame, for example: without light there is no noise
  const double reach = 1.96 * std::sqrt(log_variance(image.pixels, errors, mean, cancel));
  error.relative_rmse = std::sqrt(mean);
  error.low = std::sqrt(mean * std::exp(-reach));
  error.high = std::sqrt(mean * std::exp(reach));
  return error;
}

std::vector<double> relative_squared_errors(const NoiseImage& image) {
  const SampleExtremes samples = samples_of(image.pixels, {});
  if (image.pixels.empty() || samples.least < 2) return {};
  return relative_errors(image, samples, {}).values;
}

NoiseImage film_noise(const Film& film, const CancelToken& cancel) {
  const PixelRect& window = film.data_window();
  if (window.empty()) return {};
  return {window.width(), window.height(), film.noise(cancel)};
}

FrameError estimate_frame_error(const Film& film) {
  return estimate_frame_error(film_noise(film));
}

size_t frame_error_bytes(const PixelRect& window, uint64_t most_samples) {
  if (window.empty()) return 0;
  constexpr size_t kPixel = sizeof(PixelNoise) + 2 * sizeof(double);   // RelativeErrors: scales, values
  const size_t factors = sizeof(double) * (size_t(most_samples) + 1);  // relative_errors()
  return kPixel * size_t(window.width()) * size_t(window.height()) + factors;
}

uint32_t samples_for_error(uint32_t done, uint32_t most, double error, double target) {
  const double ratio = error / target;
  return uint32_t(std::clamp(std::ceil(done * ratio * ratio), 1.0, double(most)));
}

}  // namespace alabaster
