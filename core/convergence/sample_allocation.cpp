#include "core/convergence/sample_allocation.h"

#include <algorithm>
#include <cmath>

#include "core/convergence/frame_error.h"
#include "core/convergence/pixel_group.h"
#include "core/convergence/pixel_loop.h"

namespace alabaster {
namespace {

size_t index_in(const PixelRect& window, int x, int y) {
  return size_t(y - window.y0) * size_t(window.width()) + size_t(x - window.x0);
}

// Each pixel's relative deviation, in any unit, from its own group alone. 0 in groups that are black.
std::vector<double> relative_deviations(const NoiseImage& noise) {
  std::vector<double> deviations(noise.pixels.size());
  for (uint32_t g = 0; g < kPixelGroups; ++g) {
    const std::vector<double> errors = relative_squared_errors(noise, 1u << g);
    const std::vector<size_t> places = places_of(noise, 1u << g);
    for (size_t i = 0; i < errors.size(); ++i) deviations[places[i]] = std::sqrt(errors[i]);
  }
  return deviations;
}

// Mean over the pixels around (x, y) that allocate its samples.
double mean_around(const std::vector<double>& values, const PixelRect& window, int x, int y) {
  constexpr int kReach = 3;
  double sum = 0;
  int count = 0;
  for (int ny = std::max(window.y0, y - kReach); ny <= std::min(window.y1 - 1, y + kReach); ++ny)
    for (int nx = std::max(window.x0, x - kReach); nx <= std::min(window.x1 - 1, x + kReach); ++nx)
      if (allocates(pixel_group(nx, ny), pixel_group(x, y))) sum += values[index_in(window, nx, ny)], ++count;
  return count > 0 ? sum / count : 0;
}

double rate_of(double deviation, double scale, uint32_t total) {
  const double wanted = scale * deviation;
  const double rate = total > kPilotSamples ? (total * wanted - kPilotSamples) / (total - kPilotSamples) : wanted;
  return std::clamp(rate, double(kLeastSampleRate), double(kLargestSampleRate));
}

// The factor of all deviations that gives rates of mean one, by bisection: rates grow with it.
double find_scale(const std::vector<double>& deviations, uint32_t total) {
  const size_t n = deviations.size();
  const auto mean = sum_over_pixels<double>(n, [&](size_t i, double* sum) { *sum += deviations[i] / double(n); });
  if (!(mean > 0)) return 0;
  double low = 0, high = 64 / mean;
  for (int i = 0; i < 24; ++i) {
    const double middle = (low + high) / 2;
    const auto rates =
        sum_over_pixels<double>(n, [&](size_t k, double* sum) { *sum += rate_of(deviations[k], middle, total); });
    (rates < double(n) ? low : high) = middle;
  }
  return (low + high) / 2;
}

size_t pixels_in(const PixelRect& window) {
  return window.empty() ? 0 : size_t(window.width()) * size_t(window.height());
}

}  // namespace

size_t sample_allocation_bytes(const PixelRect& window) {
  return sizeof(float) * pixels_in(window);
}

// The frame's noise, held twice, three numbers for each pixel, and the places and the errors of a group.
size_t making_allocation_bytes(const PixelRect& window) {
  constexpr size_t kOfAGroup = 2 * sizeof(double) + 2 * sizeof(size_t);
  constexpr size_t kPixel = 2 * sizeof(PixelNoise) + 3 * sizeof(double) + sizeof(uint32_t) + kOfAGroup / kPixelGroups;
  return kPixel * pixels_in(window);
}

SampleAllocation::SampleAllocation(const Film& pilot, const std::vector<uint32_t>& rays, uint32_t total) {
  const PixelRect& window = pilot.data_window();
  const NoiseImage noise_image = film_noise(pilot);
  const std::vector<double> noise = relative_deviations(noise_image), costs(rays.begin(), rays.end());
  rates_.assign(noise.size(), 1.0f);

  // Estimate sqrt(v / c) of each pixel from those around it. The mean of roots, and not the root of a mean: one rare
  // bright sample would take the samples of all pixels around it.
  std::vector<double> deviations(noise.size());
  const auto width = static_cast<size_t>(window.width());
  for_pixel_blocks(noise.size(), [&](size_t, size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const int x = window.x0 + int(i % width), y = window.y0 + int(i / width);
      const double cost = std::max(1.0, mean_around(costs, window, x, y));
      deviations[i] = mean_around(noise, window, x, y) / std::sqrt(cost);
    }
  });

  // Turn them into rates of mean one over each group.
  for (uint32_t g = 0; g < kPixelGroups; ++g) {
    const std::vector<size_t> pixels = places_of(noise_image, 1u << g);
    std::vector<double> own;
    for (const size_t pixel : pixels) own.push_back(deviations[pixel]);
    const double scale = find_scale(own, total);
    if (!(scale > 0)) continue;
    for (size_t i = 0; i < pixels.size(); ++i) rates_[pixels[i]] = static_cast<float>(rate_of(own[i], scale, total));
  }
}

}  // namespace alabaster
