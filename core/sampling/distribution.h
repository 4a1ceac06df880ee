// Piecewise-constant distributions over [0,1) and [0,1)^2.
#pragma once

#include <cstddef>
#include <vector>

#include "core/math/vector.h"

namespace alabaster {

/// Weights must be finite and >= 0; if their sum is zero the distribution is uniform.
class Distribution1D {
 public:
  Distribution1D() = default;
  explicit Distribution1D(std::vector<float> weights);

  struct Sample {
    float x = 0;         // in [0,1)
    float pdf = 0;       // density at x
    size_t index = 0;    // cell
    float remapped = 0;  // u rescaled within the cell, in [0,1): may be used again
  };
  Sample sample(float u) const;
  float pdf(float x) const;
  /// Probability of a cell.
  float probability(size_t index) const;
  double sum() const { return sum_; }
  size_t size() const { return weights_.size(); }

 private:
  std::vector<float> weights_;
  std::vector<float> cdf_;  // size()+1 entries, 0 .. 1
  double sum_ = 0;
};

/// Rows are marginal, columns conditional; `weights` is row-major, row 0 at y = 0.
class Distribution2D {
 public:
  Distribution2D() = default;
  Distribution2D(const std::vector<float>& weights, size_t width, size_t height);

  Vec2f sample(const Vec2f& u, float* pdf) const;  // pdf per unit square
  float pdf(const Vec2f& p) const;
  bool empty() const { return rows_.empty(); }

 private:
  std::vector<Distribution1D> rows_;
  Distribution1D marginal_;
};

}  // namespace alabaster
