#include "core/convergence/sample_allocation.h"

#include <algorithm>
#include <cmath>

#include "core/convergence/frame_error.h"
#include "core/convergence/pixel_group.h"
#include "core/convergence/pixel_loop.h"

namespace alabaster {
namespace {

// Bounds of a pixel's rate: the pilot is too small to trust that a pixel has no noise, or that a rare path is not rare.
constexpr double kLeastRate = 0.125, kLargestRate = 8;

// Mean of the values within kReach pixels of (x, y).
double local_mean(const std::vector<double>& values, const NoiseImage& size, int x, int y) {
  constexpr int kReach = 2;
  double sum = 0;
  int count = 0;
  for (int ny = std::max(0, y - kReach); ny <= std::min(size.height - 1, y + kReach); ++ny)
    for (int nx = std::max(0, x - kReach); nx <= std::min(size.width - 1, x + kReach); ++nx, ++count)
      sum += values[size_t(ny) * size_t(size.width) + size_t(nx)];
  return count > 0 ? sum / count : 0;
}

size_t index_in(const PixelRect& window, int x, int y) {
  return size_t(y - window.y0) * size_t(window.width()) + size_t(x - window.x0);
}

double rate_of(double deviation, double scale, uint32_t total) {
  const double wanted = scale * deviation;
  const double rate = total > kPilotSamples ? (total * wanted - kPilotSamples) / (total - kPilotSamples) : wanted;
  return std::clamp(rate, kLeastRate, kLargestRate);
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

}  // namespace

SampleAllocation::SampleAllocation(const Film& pilot, const std::vector<uint32_t>& rays, uint32_t total) {
  const PixelRect& window = pilot.data_window();
  const std::vector<PixelNoise> noise = pilot.noise();
  rates_.assign(noise.size(), 1.0f);
  for (int g = 0; g < kPixelGroups; ++g) {
    const GroupImage own = group_image(window, noise, g);
    const GroupImage deciding = group_image(window, noise, allocating_group(g));
    const std::vector<double> errors = relative_squared_errors(deciding.noise);
    if (errors.empty()) continue;

    // Collect what the deciding group's pixels cost.
    std::vector<double> costs;
    for (int y = deciding.y0; y < window.y1; y += 2)
      for (int x = deciding.x0; x < window.x1; x += 2) costs.push_back(rays[index_in(window, x, y)]);

    // Estimate sqrt(v / c) of each of the group's own pixels from the deciding pixels around it.
    std::vector<double> deviations(own.noise.pixels.size());
    for_pixel_blocks(deviations.size(), [&](size_t, size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) {
        const int x = int(i % size_t(own.noise.width)), y = int(i / size_t(own.noise.width));
        const int there_x = std::min(x + (own.x0 - deciding.x0 + 1) / 2, deciding.noise.width - 1);
        const int there_y = std::min(y + (own.y0 - deciding.y0 + 1) / 2, deciding.noise.height - 1);
        const double cost = std::max(1.0, local_mean(costs, deciding.noise, there_x, there_y));
        deviations[i] = std::sqrt(local_mean(errors, deciding.noise, there_x, there_y) / cost);
      }
    });

    // Turn these deviations into rates of mean one.
    const double scale = find_scale(deviations, total);
    if (!(scale > 0)) continue;
    size_t next = 0;
    for (int y = own.y0; y < window.y1; y += 2)
      for (int x = own.x0; x < window.x1; x += 2)
        rates_[index_in(window, x, y)] = static_cast<float>(rate_of(deviations[next++], scale, total));
  }
}

}  // namespace alabaster
