// Separates noise from bias.
//
// A configuration is rendered several times, each time with other random numbers: these are replicas. Their scatter
// about their mean is noise, which more samples reduce. The difference of their mean from the reference is bias, which
// more samples do not reduce. Both are relative: squared errors, averaged over red, green and blue, are divided by L^2
// + f^2, the level and the floor of core/convergence/frame_error.h taken from the reference, and averaged over pixels.
//
// A denoiser's error depends on the number of samples, and so does its bias: the mean of its pictures over replicas
// less the reference, at each number of samples alone. Its noise is the scatter that is left between replicas.
//
// Every estimate here is itself unbiased. The squared difference of two noisy means exceeds the true one by the
// variances of both on average, so these variances, known from the replicas, are subtracted. An estimate may therefore
// be negative.
#pragma once

#include <cstdint>
#include <span>

#include "delegate/tradeoff/image.h"

namespace alabaster::tradeoff {

/// A number with its 95 % confidence interval.
struct Estimate {
  double value = 0, low = 0, high = 0;
  double standard_error = 0;
};

/// Squares of pixels that are independent of each other. Pixels of a render are, one by one; those of a denoised
/// picture share noise with their neighbours.
struct PixelBlocks {
  int width = 0;    // of the picture
  size_t side = 1;  // in pixels

  size_t block(size_t pixel) const {
    if (side == 1) return pixel;
    const auto w = static_cast<size_t>(width);
    return pixel / w / side * ((w + side - 1) / side) + pixel % w / side;
  }
};
/// About as far as a denoiser's noise is correlated. Smaller blocks would make intervals too narrow.
inline constexpr size_t kDenoisedBlock = 32;

/// L^2 + f^2 of each pixel of `reference`, with L the mean of red, green and blue over the 3 x 3 pixels around it and f
/// 0.05 of the frame's mean. Empty if the reference is black, because no error can be relative to it.
std::vector<double> squared_scales(const Image& reference);

/// Replicas with the same number of samples: their mean and the variance of one of them, per pixel. The four channels
/// are red, green, blue and their mean (the level), which has a variance of its own because colours are correlated.
class ReplicaGroup {
 public:
  explicit ReplicaGroup(uint64_t samples) : samples_(samples) {}
  /// All images must have the size of the first.
  void add(const Image& image);
  uint64_t samples() const { return samples_; }
  int count() const { return count_; }
  size_t pixels() const { return mean_.size() / 4; }
  double mean(size_t pixel, size_t channel) const { return mean_[4 * pixel + channel]; }
  /// Unbiased; needs two replicas.
  double variance(size_t pixel, size_t channel) const { return squares_[4 * pixel + channel] / (count_ - 1); }

 private:
  uint64_t samples_;
  int count_ = 0;
  std::vector<double> mean_, squares_;  // Welford's update
};

/// The mean of all samples of several groups, weighted by samples, and its variance: each group's own sample variance
/// times the square of its weight, so nothing is assumed about how noise falls with samples. Groups of fewer than two
/// replicas are left out because their variance is unknown.
struct PooledMean {
  std::vector<double> mean, variance;  // four channels per pixel, as in ReplicaGroup
  double samples = 0;                  // per pixel, of all groups
  size_t pixels() const { return mean.size() / 4; }
};
PooledMean pool(std::span<const ReplicaGroup> groups);

/// noise^2 of one replica of `group`, which has at least two. `scales` are those of squared_scales.
Estimate squared_noise(const ReplicaGroup& group, std::span<const double> scales, const PixelBlocks& blocks = {});

/// bias^2: mean over pixels of ((X - Y)^2 - var X - var Y) / scale. X and Y must come from independent replicas. The
/// interval follows from the scatter over blocks, which share no random numbers. It is exact for a configuration
/// without bias, and too wide, never too narrow, where the bias differs from pixel to pixel.
Estimate squared_bias(const PooledMean& x, const PooledMean& y, std::span<const double> scales,
                      const PixelBlocks& blocks = {});

/// The difference of the frames' mean levels relative to that of `y`; positive is too bright. The variances of the
/// pixels give its standard error; where pixels are correlated, the scatter of the blocks' differences, which is too
/// wide where the bias differs from block to block.
Estimate mean_level_bias(const PooledMean& x, const PooledMean& y, const PixelBlocks& blocks = {});

}  // namespace alabaster::tradeoff
