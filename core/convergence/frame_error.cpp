#include "core/convergence/frame_error.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>

#include "core/convergence/pixel_levels.h"
#include "core/convergence/pixel_loop.h"

namespace alabaster {
namespace {

double squared(float x) {
  return double(x) * double(x);
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
  PerDifference means;                // over the frame, each pixel over its scale
  PerDifference elasticity{1, 0, 0};  // d ln V(1) / d ln of each mean
  double steepest_fall = 2;  // of the differences from one power of two to the next. Independent samples have 2
};

// Mean over the frame of the differences before the latest, over that of the latest.
struct Ratios {
  double previous = 2, earlier = 4;
  // How far they go by d ln of what was measured.
  double trust_previous = 1, trust_earlier = 1;
};

// Two differences: latest = a + 3 b and previous = 2 a + 12 b. In units of the latest.
void fit_one_b(const Ratios& ratios, Convergence* c) {
  const double previous = ratios.previous, b = (previous - 2) / 6, variance = (5 - previous) / 3;
  c->law = {.a = (4 - previous) / 2, .b_even = b, .b_odd = b};
  c->elasticity.previous = -ratios.trust_previous * previous / 3 / variance;
  c->elasticity.latest = 1 - c->elasticity.previous;
}

// Three differences, in units of the latest: a + 4 o - e, 2 a + 16 e - 4 o and 4 a + 64 o - 16 e, with e = b_even and
// o = b_odd.
void fit_two_b(const Ratios& ratios, Convergence* c) {
  const double previous = ratios.previous, earlier = ratios.earlier;
  PerDifference& elasticity = c->elasticity;
  if (earlier > 16) {  // a < 0: the variance falls faster than the sum can
    const double growth = std::sqrt(earlier);
    c->law.exponent = std::log2(growth);
    elasticity.earlier = -0.5 * ratios.trust_earlier * growth / (growth - 1);
  } else {
    const double a = (16 - earlier) / 12, e = (1 + previous - 3 * a) / 15;
    c->law = {.a = a, .b_even = e, .b_odd = (1 - a + e) / 4};
    elasticity.previous = ratios.trust_previous * previous / 15 / (a + e);
    elasticity.earlier = -ratios.trust_earlier * earlier / 15 / (a + e);
  }
  elasticity.latest = 1 - elasticity.previous - elasticity.earlier;
}

// Least and most samples of a pixel.
struct SampleExtremes {
  uint32_t least = ~0u, most = 0;
  void operator+=(const SampleExtremes& o) {
    least = std::min(least, o.least);
    most = std::max(most, o.most);
  }
};

SampleExtremes samples_of(const PixelSet& pixels, const CancelToken& cancel) {
  return sum_over_pixels<SampleExtremes>(
      pixels.size(),
      [&](size_t i, SampleExtremes* all) {
        *all += {pixels[i].samples, pixels[i].samples};
      },
      cancel);
}

// The likely value of a ratio, from its measured one and the variance of the logarithm of that. Without noise in the
// measurement it is the measured one, and without a measurement `independent`, that of independent samples. `spread`:
// the standard deviation of its logarithm over integrands.
double likely_ratio(double measured, double variance, double independent, double spread, double* trust) {
  *trust = spread * spread / (spread * spread + variance);
  return independent * std::pow(measured / independent, *trust);
}

// Beyond these bounds there is only chance: independent samples have 2 and 4, a smooth integrand of one dimension 8 and
// 64. Few bright samples make the ratios chance within the bounds, too.
Ratios ratios_of(const PixelSet& pixels, const std::vector<double>& scales, const PerDifference& means,
                 double most_previous, const CancelToken& cancel) {
  const auto n = double(pixels.size());
  const auto variances = sum_over_pixels<PerDifference>(
      pixels.size(),
      [&](size_t i, PerDifference* sum) {
        const auto part = [&](float difference, double mean) {
          const double d = mean > 0 ? squared(difference) / scales[i] / mean - 1 : 0.0;
          return d * d / (n * n);
        };
        *sum += {part(pixels[i].latest, means.latest), part(pixels[i].previous, means.previous),
                 part(pixels[i].earlier, means.earlier)};
      },
      cancel);
  Ratios ratios;
  ratios.previous = likely_ratio(std::clamp(means.previous / means.latest, 1.0, most_previous),
                                 variances.latest + variances.previous, 2, 0.7, &ratios.trust_previous);
  ratios.earlier = likely_ratio(std::clamp(means.earlier / means.latest, 2.0, 64.0),
                                variances.latest + variances.earlier, 4, 1.4, &ratios.trust_earlier);
  return ratios;
}

// One law for the whole frame, since the ratios of one pixel are noise.
Convergence fit_convergence(const PixelSet& pixels, const std::vector<double>& scales, uint32_t least,
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
  const Ratios ratios = ratios_of(pixels, scales, means, least < 8 ? 4.0 : 8.0, cancel);
  c.steepest_fall = std::max(c.steepest_fall, ratios.previous);
  if (least < 8) {
    fit_one_b(ratios, &c);
  } else {
    c.steepest_fall = std::max(c.steepest_fall, std::sqrt(ratios.earlier));
    fit_two_b(ratios, &c);
  }
  return c;
}

// The variances of pixels' means by a law, from their differences.
class Variances {
 public:
  Variances(const ConvergenceLaw& law, uint32_t most) : law_(law), factors_(size_t(most) + 1) {}
  double of(const PixelNoise& pixel) const {
    std::atomic<double>& shared = factors_[pixel.samples];
    double factor = shared.load(std::memory_order_relaxed);
    if (factor == 0) shared = factor = variance_per_difference(pixel.samples, law_);
    return factor * squared(pixel.difference());
  }

 private:
  ConvergenceLaw law_;
  mutable std::vector<std::atomic<double>> factors_;  // by number of samples; 0: not computed yet
};

// L^2 + f^2 of every pixel, and the variance of each pixel's mean over that, which is computed when it is used: the
// scales are all of a frame's size that is kept.
class RelativeErrors {
 public:
  /// The pixels must outlive it.
  RelativeErrors(const PixelSet& pixels, std::vector<double> scales, const SampleExtremes& samples,
                 const CancelToken& cancel)
      : pixels_(pixels),
        scales_(std::move(scales)),
        convergence_(fit_convergence(pixels, scales_, samples.least, cancel)),
        variances_(convergence_.law, samples.most) {}
  const Convergence& convergence() const { return convergence_; }
  double scale(size_t i) const { return scales_[i]; }
  double value(size_t i) const { return variances_.of(pixels_[i]) / scales_[i]; }

 private:
  const PixelSet& pixels_;
  std::vector<double> scales_;
  Convergence convergence_;
  Variances variances_;
};

// Sum over the n pixels of value(i) / n.
template <class Value>
double mean_of(size_t n, const Value& value, const CancelToken& cancel) {
  return sum_over_pixels<double>(
      n, [&](size_t i, double* sum) { *sum += value(i) / double(n); }, cancel);
}

constexpr double kNoiseDoubt = 0.12;  // about ln E^2 of independent samples

// How far ln E^2 may be off (frame_error.md, "The interval").
struct LogScatter {
  double variance = 0;
  double effective = 0;  // squared errors as if they were equal: n that have their mean and mean square (Kish 1965)
};

/// The scatter of the estimate over pixels, that of the true error, and the doubt about the law. `value`: the squared
/// error of each pixel, whose mean is `mean`.
template <class Value>
LogScatter log_scatter(const PixelSet& pixels, const RelativeErrors& errors, const Value& value, double mean,
                       const CancelToken& cancel) {
  constexpr double kStratifiedDoubt = 0.5;
  const ConvergenceLaw& law = errors.convergence().law;
  const PerDifference &means = errors.convergence().means, &elasticity = errors.convergence().elasticity;
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
        const double scale = errors.scale(i);
        const double d = value(i) / mean - 1;
        const double e = d + part(elasticity.latest - 1, pixels[i].latest, scale, means.latest) +
                         part(elasticity.previous, pixels[i].previous, scale, means.previous) +
                         part(elasticity.earlier, pixels[i].earlier, scale, means.earlier);
        *squares += {d * d, e * e};
      },
      cancel);
  const auto n = double(pixels.size());
  return {(sum.truth + sum.estimate) / std::max(1.0, n - 1) / n + doubt * doubt, n * n / (sum.truth + n)};
}

// L^2 + f^2 of every pixel, where L is level(range).
template <class Level>
std::vector<double> squared_scales(const PixelSet& pixels, double floor, const Level& level,
                                   const CancelToken& cancel) {
  std::vector<double> scales(pixels.size());
  visit_levels(
      pixels,
      [&](size_t, size_t i, const LevelRange& range) {
        const double l = level(range);
        scales[i] = l * l + floor * floor;
      },
      cancel);
  return scales;
}

double lowest_level(const LevelRange& range) {
  return range.low;
}

// L^2 + f^2 of every pixel with levels as low as they may be, and the effective number of the pixels that stand out of
// their neighbours: how many of equal squared errors have the mean and the mean square of theirs (Kish 1965, "Survey
// Sampling").
struct Lowest {
  std::vector<double> scales;
  double outliers = 0;
};

Lowest lowest_scales(const PixelSet& pixels, double floor, const CancelToken& cancel) {
  struct Moments {
    double sum = 0, squares = 0;
  };
  Lowest lowest{std::vector<double>(pixels.size()), 0};
  std::vector<Moments> blocks(level_blocks(pixels.image()));
  visit_levels(
      pixels,
      [&](size_t block, size_t i, const LevelRange& range) {
        const double l = lowest_level(range);
        lowest.scales[i] = l * l + floor * floor;
        if (!(range.excess > 0)) return;
        const double value = squared(pixels[i].difference()) / lowest.scales[i];
        blocks[block].sum += value;
        blocks[block].squares += value * value;
      },
      cancel);
  Moments all;
  for (const Moments& block : blocks) {
    all.sum += block.sum;
    all.squares += block.squares;
  }
  if (all.squares > 0) lowest.outliers = all.sum * all.sum / all.squares;
  return lowest;
}

// The upper end of E^2 if stratification has ended its work: the last difference is then that of independent samples
// (frame_error.md, "The interval"). Where noise rules, it lies below the other upper end.
double high_without_strata(const PixelSet& pixels, const std::vector<double>& scales, uint32_t most,
                           const CancelToken& cancel) {
  const Variances variances({}, most);
  const auto value = [&](size_t i) { return variances.of(pixels[i]) / scales[i]; };
  return mean_of(pixels.size(), value, cancel) * std::exp(1.96 * kNoiseDoubt);
}

// The lower end of E^2 if the variance falls on as steeply as it did: by a power law, as that of hair does
// (frame_error.md, "The interval"). Where noise rules, it is the other lower end without the scatter.
double low_of_power_law(const PixelSet& pixels, const RelativeErrors& errors, uint32_t most,
                        const CancelToken& cancel) {
  const Variances variances({.exponent = std::log2(errors.convergence().steepest_fall)}, most);
  const auto value = [&](size_t i) { return variances.of(pixels[i]) / errors.scale(i); };
  return mean_of(pixels.size(), value, cancel) * std::exp(-1.96 * kNoiseDoubt);
}

}  // namespace

FrameError estimate_frame_error(const NoiseImage& image, const CancelToken& cancel, uint32_t groups) {
  const PixelSet pixels(image, groups);
  const SampleExtremes samples = samples_of(pixels, cancel);
  if (pixels.size() == 0 || samples.least < 2) return {};
  const double floor = error_floor(pixels, cancel);
  if (floor == 0) return {.known = true};  // a black frame: without light there is no noise
  if (!std::isfinite(floor)) return {.known = false, .relative_rmse = floor};
  const Lowest lowest = lowest_scales(pixels, floor, cancel);
  // Around a pixel that stands out, its neighbours may have the same light and have missed it. The more such pixels
  // there are and the fewer of them lie together, the less of it.
  const double alone = 1 / (9 * (1 + lowest.outliers));
  const auto highest_level = [alone](const LevelRange& range) { return range.high + alone * range.excess; };

  // Least and most error: with the highest levels and with the lowest. The law is one, that of the former, in which few
  // bright samples weigh less.
  const size_t n = pixels.size();
  const RelativeErrors errors(pixels, squared_scales(pixels, floor, highest_level, cancel), samples, cancel);
  const auto at_least = [&](size_t i) { return errors.value(i); };
  const auto at_most = [&](size_t i) { return errors.value(i) * (errors.scale(i) / lowest.scales[i]); };
  const double least = mean_of(n, at_least, cancel);
  if (!std::isfinite(least)) return {.known = false, .relative_rmse = least};
  if (!(least > 0)) return {.known = true};
  const double least_reach = 1.96 * std::sqrt(log_scatter(pixels, errors, at_least, least, cancel).variance);
  const double most = mean_of(n, at_most, cancel);
  if (!std::isfinite(most)) return {.known = false, .relative_rmse = most};
  const LogScatter scatter = log_scatter(pixels, errors, at_most, most, cancel);
  // Light that few samples find is missed by others: a sum of few terms is more often too small than too large.
  constexpr double kSkewness = 1.5, kFewest = 4;
  const double most_reach =
      1.96 * std::sqrt(scatter.variance) * (1 + kSkewness / std::sqrt(kFewest + scatter.effective));
  constexpr double kWeightOfMost = 2.0 / 3;
  return {.known = true,
          .relative_rmse = std::sqrt(least * std::pow(most / least, kWeightOfMost)),
          .low = std::sqrt(
              std::min(least * std::exp(-least_reach), low_of_power_law(pixels, errors, samples.most, cancel))),
          .high = std::sqrt(
              std::max(most * std::exp(most_reach), high_without_strata(pixels, lowest.scales, samples.most, cancel)))};
}

std::vector<double> relative_squared_errors(const NoiseImage& image, uint32_t groups) {
  const PixelSet pixels(image, groups);
  const SampleExtremes samples = samples_of(pixels, {});
  const double floor = error_floor(pixels, {});
  if (pixels.size() == 0 || samples.least < 2 || floor == 0 || !std::isfinite(floor)) return {};
  const RelativeErrors errors(pixels, squared_scales(pixels, floor, lowest_level, {}), samples, {});
  std::vector<double> values(pixels.size());
  for (size_t i = 0; i < values.size(); ++i) values[i] = errors.value(i);
  return values;
}

NoiseImage film_noise(const Film& film, const CancelToken& cancel) {
  const PixelRect& window = film.data_window();
  if (window.empty()) return {};
  return {window.width(), window.height(), film.noise(cancel), window.x0, window.y0};
}

FrameError estimate_frame_error(const Film& film) {
  return estimate_frame_error(film_noise(film));
}

size_t frame_error_bytes(const PixelRect& window, uint64_t most_samples) {
  if (window.empty()) return 0;
  constexpr size_t kPixel = sizeof(PixelNoise) + 2 * sizeof(double);       // RelativeErrors, Lowest
  const size_t factors = 2 * sizeof(double) * (size_t(most_samples) + 1);  // of two laws
  return kPixel * size_t(window.width()) * size_t(window.height()) + factors;
}

uint32_t samples_for_error(uint32_t done, uint32_t most, double error, double target) {
  const double ratio = error / target;
  return uint32_t(std::clamp(std::ceil(done * ratio * ratio), 1.0, double(most)));
}

}  // namespace alabaster
