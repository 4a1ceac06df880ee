#include "core/sampling/distribution.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace alabaster {
namespace {

// Random numbers come in steps of 2^-24; float holds every multiple of it in [0, 1].
constexpr int64_t kSteps = int64_t(1) << 24;

}  // namespace

Distribution1D::Distribution1D(const std::vector<float>& weights, const CancelToken& cancel) {
  for (float w : weights) {
    cancel.check();
    sum_ += w;
  }
  if (weights.empty()) return;
  const bool uniform = !(sum_ > 0);
  const auto weight = [&](size_t i) { return uniform ? 1.0 : static_cast<double>(weights[i]); };
  const double total = uniform ? static_cast<double>(weights.size()) : sum_;
  int64_t positive = 0;
  for (size_t i = 0; i < weights.size(); ++i) {
    cancel.check();
    positive += weight(i) > 0 ? 1 : 0;
  }
  const int64_t least = positive <= kSteps ? 1 : 0;

  cdf_.reserve(weights.size() + 1);
  cdf_.push_back(0);
  int64_t steps = 0, left = positive;
  double running = 0;
  for (size_t i = 0; i < weights.size(); ++i) {
    cancel.check();
    if (weight(i) > 0) {
      running += weight(i);
      --left;
      const int64_t ideal = left == 0 ? kSteps : std::llround(running / total * static_cast<double>(kSteps));
      steps = std::max(steps + least, std::min(ideal, kSteps - left * least));
    }
    cdf_.push_back(static_cast<float>(steps) / static_cast<float>(kSteps));
  }
  make_guide(cancel);
}

void Distribution1D::make_guide(const CancelToken& cancel) {
  constexpr size_t kCellsAPart = 4;
  const size_t parts =
      std::bit_ceil(size()) / kCellsAPart;  // a power of two, so that multiples of its inverse are exact
  if (parts < 2) return;
  guide_.reserve(parts + 1);
  size_t cell = 0;
  for (size_t part = 0; part < parts; ++part) {
    cancel.check();
    const float begin = static_cast<float>(part) / static_cast<float>(parts);
    while (cdf_[cell + 1] <= begin) ++cell;
    guide_.push_back(static_cast<uint32_t>(cell));
  }
  guide_.push_back(static_cast<uint32_t>(size() - 1));
}

float Distribution1D::probability(size_t index) const {
  return cdf_[index + 1] - cdf_[index];
}

Distribution1D::Sample Distribution1D::sample(float u) const {
  // The cell whose range holds u: the last whose lower bound is <= u, so never one without width.
  u = std::clamp(u, 0.0f, kOneMinusEpsilon);
  auto begin = cdf_.begin(), end = cdf_.end();
  if (!guide_.empty()) {
    const auto part = static_cast<size_t>(u * static_cast<float>(guide_.size() - 1));
    end = begin + guide_[part + 1] + 2;
    begin += guide_[part];
  }
  const auto above = std::upper_bound(begin, end, u);
  Sample s;
  s.index = static_cast<size_t>(above - cdf_.begin()) - 1;
  const float width = probability(s.index);
  // u stands for its whole step: its middle, or a narrow cell would only ever give its lower end.
  s.remapped = std::min((u - cdf_[s.index] + 0.5f / static_cast<float>(kSteps)) / width, kOneMinusEpsilon);
  s.x = std::min((static_cast<float>(s.index) + s.remapped) / static_cast<float>(size()), kOneMinusEpsilon);
  while (cell_of(s.x) < s.index) s.x = std::nextafter(s.x, 1.0f);
  while (cell_of(s.x) > s.index) s.x = std::nextafter(s.x, 0.0f);
  s.pdf = width * static_cast<float>(size());
  return s;
}

size_t Distribution1D::cell_of(float x) const {
  return std::min(static_cast<size_t>(std::max(0.0f, x * static_cast<float>(size()))), size() - 1);
}

float Distribution1D::pdf(float x) const {
  return probability(cell_of(x)) * static_cast<float>(size());
}

Distribution2D::Distribution2D(size_t width, size_t height, const FillRow& fill, const CancelToken& cancel) {
  rows_.resize(height);
  tbb::parallel_for(size_t(0), height, [&](size_t y) {
    cancel.check();
    std::vector<float> row(width);
    fill(y, row);
    rows_[y] = Distribution1D(row);
  });
  double largest = 0;
  for (const Distribution1D& row : rows_) largest = std::max(largest, row.sum());
  // Relative to the largest: a sum of floats may leave their range.
  std::vector<float> marginal;
  marginal.reserve(height);
  for (const Distribution1D& row : rows_) {
    const double sum = row.sum();
    marginal.push_back(sum > 0 ? std::max(static_cast<float>(sum / largest), std::numeric_limits<float>::min()) : 0);
  }
  marginal_ = Distribution1D(marginal);
}

Distribution2D::Distribution2D(const std::vector<float>& weights, size_t width, size_t height,
                               const CancelToken& cancel)
    : Distribution2D(
          width, height,
          [&](size_t y, std::span<float> row) { std::copy_n(weights.data() + y * width, width, row.begin()); },
          cancel) {}

Distribution2D::Cell Distribution2D::sample(const Vec2f& u) const {
  const auto y = marginal_.sample(u.y);
  const auto x = rows_[y.index].sample(u.x);
  return {x.index, y.index, {x.remapped, y.remapped}};
}

float Distribution2D::probability(size_t x, size_t y) const {
  return marginal_.probability(y) * rows_[y].probability(x);
}

size_t Distribution2D::memory_bytes() const {
  size_t bytes = marginal_.memory_bytes() + rows_.capacity() * sizeof(Distribution1D);
  for (const Distribution1D& row : rows_) bytes += row.memory_bytes();
  return bytes;
}

}  // namespace alabaster
