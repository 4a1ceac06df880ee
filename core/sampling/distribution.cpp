#include "core/sampling/distribution.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace alabaster {

Distribution1D::Distribution1D(std::vector<float> weights) : weights_(std::move(weights)) {
  const size_t n = weights_.size();
  for (float w : weights_) sum_ += w;
  if (!(sum_ > 0)) {
    std::fill(weights_.begin(), weights_.end(), 1.0f);
    sum_ = 0;
  }
  const double total = sum_ > 0 ? sum_ : static_cast<double>(n);
  cdf_.resize(n + 1);
  double running = 0;
  for (size_t i = 0; i < n; ++i) {
    cdf_[i] = static_cast<float>(running / total);
    running += weights_[i];
  }
  if (n > 0) cdf_[n] = 1;
}

float Distribution1D::probability(size_t index) const {
  return cdf_[index + 1] - cdf_[index];
}

Distribution1D::Sample Distribution1D::sample(float u) const {
  // Last cell whose lower bound is <= u and that has width: cells of weight zero are never chosen.
  const auto above = std::upper_bound(cdf_.begin(), cdf_.end() - 1, u);
  auto index = static_cast<size_t>(above - cdf_.begin()) - 1;
  while (index > 0 && probability(index) == 0) --index;
  while (index + 1 < size() && probability(index) == 0) ++index;
  Sample s;
  s.index = index;
  const float width = probability(index);
  s.remapped = std::clamp((u - cdf_[index]) / width, 0.0f, kOneMinusEpsilon);
  s.x = std::min((static_cast<float>(index) + s.remapped) / static_cast<float>(size()), kOneMinusEpsilon);
  s.pdf = width * static_cast<float>(size());
  return s;
}

float Distribution1D::pdf(float x) const {
  const auto n = static_cast<float>(size());
  const auto index = std::min(static_cast<size_t>(std::max(0.0f, x * n)), size() - 1);
  return probability(index) * n;
}

Distribution2D::Distribution2D(const std::vector<float>& weights, size_t width, size_t height) {
  std::vector<float> sums(height);
  rows_.reserve(height);
  for (size_t y = 0; y < height; ++y) {
    const auto begin = weights.begin() + static_cast<std::ptrdiff_t>(y * width);
    rows_.emplace_back(std::vector<float>(begin, begin + static_cast<std::ptrdiff_t>(width)));
    sums[y] = static_cast<float>(rows_.back().sum());
  }
  marginal_ = Distribution1D(std::move(sums));
}

Vec2f Distribution2D::sample(const Vec2f& u, float* pdf) const {
  const auto y = marginal_.sample(u.y);
  const auto x = rows_[y.index].sample(u.x);
  *pdf = x.pdf * y.pdf;
  return {x.x, y.x};
}

float Distribution2D::pdf(const Vec2f& p) const {
  const auto rows = static_cast<float>(rows_.size());
  const auto row = std::min(static_cast<size_t>(std::max(0.0f, p.y * rows)), rows_.size() - 1);
  return marginal_.pdf(p.y) * rows_[row].pdf(p.x);
}

}  // namespace alabaster
