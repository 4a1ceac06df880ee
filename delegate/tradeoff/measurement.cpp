#include "delegate/tradeoff/measurement.h"

#include <algorithm>
#include <cmath>

namespace alabaster::tradeoff {
namespace {

constexpr double kFloor = 0.05;         // kErrorFloor of core/convergence/frame_error.h; a test compares the two
constexpr double kNormal95 = 1.959964;  // two-sided 95 % of the normal distribution

double level(const Image& image, size_t pixel) {
  return (double(image.rgb[3 * pixel]) + double(image.rgb[3 * pixel + 1]) + double(image.rgb[3 * pixel + 2])) / 3;
}

Estimate with_interval(double value, double standard_error) {
  return {value, value - kNormal95 * standard_error, value + kNormal95 * standard_error, standard_error};
}

/// Mean of the pixels' values, and its standard error from the independent sums of blocks.
Estimate mean_of(std::span<const double> values, const PixelBlocks& blocks) {
  const auto n = double(values.size());
  double mean = 0, squares = 0;
  for (const double value : values) mean += value / n;
  std::vector<double> sums(values.empty() ? 0 : blocks.block(values.size() - 1) + 1, 0.0);
  for (size_t pixel = 0; pixel < values.size(); ++pixel) sums[blocks.block(pixel)] += values[pixel] - mean;
  for (const double sum : sums) squares += sum * sum;
  const auto count = double(sums.size());
  return with_interval(mean, count > 1 ? std::sqrt(squares * count / (count - 1)) / n : std::abs(mean));
}

}  // namespace

std::vector<double> squared_scales(const Image& reference) {
  double frame = 0;
  for (size_t i = 0; i < reference.pixels(); ++i) frame += level(reference, i) / double(reference.pixels());
  if (!(frame > 0)) return {};
  const double floor = kFloor * frame;
  std::vector<double> scales(reference.pixels());
  const auto width = static_cast<size_t>(reference.width), height = static_cast<size_t>(reference.height);
  for (size_t y = 0; y < height; ++y)
    for (size_t x = 0; x < width; ++x) {
      double sum = 0;
      int count = 0;
      for (size_t ny = y - std::min<size_t>(y, 1); ny <= std::min(height - 1, y + 1); ++ny)
        for (size_t nx = x - std::min<size_t>(x, 1); nx <= std::min(width - 1, x + 1); ++nx, ++count)
          sum += level(reference, ny * width + nx);
      scales[y * width + x] = sum / count * (sum / count) + floor * floor;
    }
  return scales;
}

void ReplicaGroup::add(const Image& image) {
  if (count_ == 0) {
    mean_.assign(4 * image.pixels(), 0.0);
    squares_.assign(4 * image.pixels(), 0.0);
  }
  ++count_;
  for (size_t pixel = 0; pixel < pixels(); ++pixel)
    for (size_t channel = 0; channel < 4; ++channel) {
      const double value = channel < 3 ? double(image.rgb[3 * pixel + channel]) : level(image, pixel);
      double& mean = mean_[4 * pixel + channel];
      const double before = value - mean;
      mean += before / count_;
      squares_[4 * pixel + channel] += before * (value - mean);
    }
}

PooledMean pool(std::span<const ReplicaGroup> groups) {
  PooledMean pooled;
  for (const ReplicaGroup& group : groups)
    if (group.count() >= 2) pooled.samples += double(group.samples()) * group.count();
  for (const ReplicaGroup& group : groups) {
    if (group.count() < 2) continue;
    pooled.mean.resize(4 * group.pixels(), 0.0);
    pooled.variance.resize(4 * group.pixels(), 0.0);
    const double weight = double(group.samples()) / pooled.samples;  // of one replica
    for (size_t pixel = 0; pixel < group.pixels(); ++pixel)
      for (size_t channel = 0; channel < 4; ++channel) {
        pooled.mean[4 * pixel + channel] += weight * group.count() * group.mean(pixel, channel);
        pooled.variance[4 * pixel + channel] += weight * weight * group.count() * group.variance(pixel, channel);
      }
  }
  return pooled;
}

Estimate squared_noise(const ReplicaGroup& group, std::span<const double> scales, const PixelBlocks& blocks) {
  std::vector<double> values(group.pixels());
  for (size_t pixel = 0; pixel < values.size(); ++pixel) {
    double sum = 0;
    for (size_t channel = 0; channel < 3; ++channel) sum += group.variance(pixel, channel) / 3;
    values[pixel] = sum / scales[pixel];
  }
  return mean_of(values, blocks);
}

Estimate squared_bias(const PooledMean& x, const PooledMean& y, std::span<const double> scales,
                      const PixelBlocks& blocks) {
  std::vector<double> values(x.pixels());
  for (size_t pixel = 0; pixel < values.size(); ++pixel) {
    double sum = 0;
    for (size_t i = 4 * pixel; i < 4 * pixel + 3; ++i)
      sum += ((x.mean[i] - y.mean[i]) * (x.mean[i] - y.mean[i]) - x.variance[i] - y.variance[i]) / 3;
    values[pixel] = sum / scales[pixel];
  }
  return mean_of(values, blocks);
}

Estimate mean_level_bias(const PooledMean& x, const PooledMean& y, const PixelBlocks& blocks) {
  double variance = 0, frame = 0;
  std::vector<double> differences;
  for (size_t i = 3; i < x.mean.size(); i += 4) {
    differences.push_back(x.mean[i] - y.mean[i]);
    variance += x.variance[i] + y.variance[i];
    frame += y.mean[i];
  }
  if (!(frame > 0)) return {};
  const Estimate mean = mean_of(differences, blocks);
  const auto pixels = double(differences.size());
  const double deviation = blocks.side > 1 ? mean.standard_error * pixels : std::sqrt(variance);
  return with_interval(mean.value * pixels / frame, deviation / frame);
}

}  // namespace alabaster::tradeoff
