#include "core/film/frame_error.h"

#include <algorithm>
#include <cmath>

namespace alabaster {
namespace {

struct Size {
  int width, height;
};

std::vector<double> levels_of(const std::vector<float>& rgba) {
  std::vector<double> levels(rgba.size() / 4);
  for (size_t i = 0; i < levels.size(); ++i)
    levels[i] = (double(rgba[4 * i]) + double(rgba[4 * i + 1]) + double(rgba[4 * i + 2])) / 3;
  return levels;
}

/// L^2 + f^2 of every pixel; empty if the frame is black.
std::vector<double> squared_scales(const std::vector<float>& rgba, const Size& size) {
  const std::vector<double> levels = levels_of(rgba);
  double mean = 0;
  for (double level : levels) mean += level / double(levels.size());
  if (!(mean > 0)) return {};
  const double floor = kErrorFloor * mean;
  std::vector<double> scales(levels.size());
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      double sum = 0;
      int count = 0;
      for (int ny = std::max(0, y - 1); ny <= std::min(size.height - 1, y + 1); ++ny)
        for (int nx = std::max(0, x - 1); nx <= std::min(size.width - 1, x + 1); ++nx, ++count)
          sum += levels[size_t(ny) * size_t(size.width) + size_t(nx)];
      const double level = sum / count;
      scales[size_t(y) * size_t(size.width) + size_t(x)] = level * level + floor * floor;
    }
  return scales;
}

}  // namespace

// A frame's own error scatters about its expectation as the estimate does, and independently: a - b and a + b are
// uncorrelated. So the interval is sqrt(2) wider than that of the mean alone.
FrameError estimate_frame_error(const Film& film) {
  FrameError error;
  const PixelRect& window = film.data_window();
  if (window.empty() || !(film.aovs() & aov_bit(Aov::error))) return error;
  const std::vector<float> deviation = film.resolve_float(Aov::error);
  const std::vector<int32_t> samples = film.resolve_int(Aov::sample_count);
  if (std::any_of(samples.begin(), samples.end(), [](int32_t n) { return n < 2; })) return error;
  const auto scales = squared_scales(film.resolve_float(Aov::color), {window.width(), window.height()});
  error.known = true;
  if (scales.empty()) return error;  // black: without light there is no noise
  const auto n = double(scales.size());
  double sum = 0, squares = 0;
  for (size_t i = 0; i < scales.size(); ++i) {
    const double x = double(deviation[i]) * double(deviation[i]) / scales[i];
    sum += x;
    squares += x * x;
  }
  const double mean = sum / n;
  const double variance = n > 1 ? std::max(0.0, squares / n - mean * mean) / (n - 1) : mean * mean;
  const double reach = 1.96 * std::sqrt(2 * variance);
  error.relative_rmse = std::sqrt(mean);
  error.low = std::sqrt(std::max(0.0, mean - reach));
  error.high = std::sqrt(mean + reach);
  return error;
}

double relative_mse(const std::vector<float>& image, const std::vector<float>& reference, int width, int height) {
  const auto scales = squared_scales(reference, {width, height});
  double sum = 0;
  for (size_t i = 0; i < scales.size(); ++i) {
    double squared = 0;
    for (size_t c = 0; c < 3; ++c) squared += std::pow(double(image[4 * i + c]) - double(reference[4 * i + c]), 2) / 3;
    sum += squared / scales[i];
  }
  return scales.empty() ? 0 : sum / double(scales.size());
}

}  // namespace alabaster
