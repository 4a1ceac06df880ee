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
// V(m/2) - V(m) = 1, where x = 1 stands for m samples. It is a / x + b / x^2, noise together with what stratification
// takes away, b one number at even and one at odd powers of two: a scrambled net's strata are squares at every other
// one. All three are linear in the differences at three sizes, so that a mixture of pixels is as good as one. Where a
// smooth integrand has the frame for itself it falls more steeply: x^-p.
struct ConvergenceLaw {
  double noise = 1, here = 0, between = 0;  // a, b where x is a power of four, b elsewhere
  double exponent = 0;                      // p; 0: the sum above

  /// The part of V(1) that noise has not, 0..1.
  double stratified() const {
    return exponent > 0 ? 1 : std::clamp(std::abs(here) / (noise + std::abs(here)), 0.0, 1.0);
  }
  double variance(double x) const {
    if (exponent > 0) return std::pow(x, -exponent) / (std::exp2(exponent) - 1);
    const bool at_four = std::lround(std::log2(x)) % 2 == 0;
    return noise / x + (at_four ? here : between) / (x * x);
  }
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

// Variance of the mean of n samples over the expectation of PixelNoise::difference().
double variance_per_difference(uint32_t n, const ConvergenceLaw& law) {
  const uint32_t m = std::bit_floor(n), rest = n - m;
  const SampleTree tree{law, double(m)};
  const double variance = tree.sum_variance(n) / (double(n) * n);
  if (!PixelNoise::uses_tail(n)) return variance / 4;
  return variance / (tree.variance(m) + tree.sum_variance(rest) / (double(rest) * rest) - 2 * tree.covariance(m));
}

struct Convergence {
  ConvergenceLaw law;
  // Means of the differences, and by how much each is in ln V(1).
  double latest = 0, previous = 0, earlier = 0;
  double by_latest = 1, by_previous = 0, by_earlier = 0;
};

// V(m) = a + b: from two differences, if b were one number; a frame of four to seven samples knows no more.
void assume_one_law(double previous, Convergence* c) {
  c->law.noise = (4 - previous) / 2;
  c->law.here = c->law.between = (previous - 2) / 6;
  const double variance = (5 - previous) / 3;
  c->by_latest = 5.0 / 3 / variance;
  c->by_previous = -previous / 3 / variance;
}

// The differences are a + 4 o - e, 2 a + 16 e - 4 o and 4 a + 64 o - 16 e, with e the b at m and o that at m / 2.
void assume_alternating_law(double previous, double earlier, Convergence* c) {
  if (earlier > 16) {  // less than no noise
    const double growth = std::sqrt(earlier);
    c->law.exponent = std::log2(growth);
    c->by_earlier = -0.5 * growth / (growth - 1);
    c->by_latest = 1 - c->by_earlier;
    return;
  }
  const double a = (16 - earlier) / 12, e = (1 + previous - 3 * a) / 15;
  c->law = {a, e, (1 - a + e) / 4};
  c->by_latest = 17.0 / 15 / (a + e);
  c->by_previous = previous / 15 / (a + e);
  c->by_earlier = -earlier / 15 / (a + e);
}

// From the whole frame: a pixel's own ratios are noise.
Convergence measure_convergence(const std::vector<PixelNoise>& pixels, const std::vector<double>& scales) {
  Convergence c;
  uint32_t least = pixels.front().samples;
  const auto n = double(pixels.size());
  for (size_t i = 0; i < pixels.size(); ++i) {
    least = std::min(least, pixels[i].samples);
    c.latest += pixels[i].latest / scales[i] / n;
    c.previous += pixels[i].previous / scales[i] / n;
    c.earlier += pixels[i].earlier / scales[i] / n;
  }
  if (!(c.latest > 0) || !(c.previous > 0) || !(c.earlier > 0)) least = std::min(least, c.previous > 0 ? 7u : 3u);
  if (least < 4 || !(c.latest > 0)) return {};
  // Beyond these there is only chance: independent samples have 2 and 4, a smooth integrand of one dimension 8 and 64.
  const double previous = std::clamp(c.previous / c.latest, 1.0, least < 8 ? 4.0 : 8.0);
  if (least < 8)
    assume_one_law(previous, &c);
  else
    assume_alternating_law(previous, std::clamp(c.earlier / c.latest, 2.0, 64.0), &c);
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
  std::vector<double> factors;  // by number of samples; 0: not computed yet
  for (size_t i = 0; i < pixels.size(); ++i) {
    const uint32_t n = pixels[i].samples;
    if (n >= factors.size()) factors.resize(2 * size_t(n));
    if (factors[n] == 0) factors[n] = variance_per_difference(n, t.convergence.law);
    t.values[i] = factors[n] * pixels[i].difference() / t.scales[i];
  }
  return t;
}

// Variance of ln E^2 by the scatter over pixels, twice: of what the estimate is made of, and of the frame's own error,
// which scatters about its expectation as much as the terms and independently of them (a - b and a + b are
// uncorrelated). Third, what the law is not sure of: little where noise rules, much where stratification does.
double log_variance(const std::vector<PixelNoise>& pixels, const Terms& t, double mean) {
  constexpr double kSure = 0.05, kUnsure = 0.5;
  const Convergence& c = t.convergence;
  const double law = kSure + kUnsure * c.law.stratified();
  const auto part = [](double weight, float difference, double scale, double of) {
    return of > 0 ? weight * (difference / scale / of - 1) : 0.0;
  };
  double own = 0, estimate = 0;
  for (size_t i = 0; i < pixels.size(); ++i) {
    const double d = t.values[i] / mean - 1;
    const double e = d + part(c.by_latest - 1, pixels[i].latest, t.scales[i], c.latest) +
                     part(c.by_previous, pixels[i].previous, t.scales[i], c.previous) +
                     part(c.by_earlier, pixels[i].earlier, t.scales[i], c.earlier);
    own += d * d;
    estimate += e * e;
  }
  const auto n = double(pixels.size());
  return (own + estimate) / std::max(1.0, n - 1) / n + law * law;
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
  error.relative_rmse = std::sqrt(mean);
  error.low = std::sqrt(mean * std::exp(-reach));
  error.high = std::sqrt(mean * std::exp(reach));
  return error;
}

std::vector<double> relative_squared_errors(const NoiseImage& image) {
  return all_have_two_samples(image) ? make_terms(image).values : std::vector<double>();
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
