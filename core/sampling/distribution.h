// Piecewise-constant distributions over [0,1) and [0,1)^2.
//
// Random numbers have 24 bits (to_unit_float), so the probabilities are whole multiples of 2^-24: a cell is chosen
// exactly as often as probability() says. Every cell of positive weight has at least one such step, unless there are
// more cells than steps.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "core/diagnostics/cancel.h"

#include "core/math/vector.h"

namespace alabaster {

/// Weights must be finite and >= 0; if their sum is zero the distribution is uniform. Without weights it is empty and
/// may not be sampled.
class Distribution1D {
 public:
  Distribution1D() = default;
  explicit Distribution1D(const std::vector<float>& weights, const CancelToken& cancel = {});

  struct Sample {
    float x = 0;         // in [0,1), and in the cell: pdf(x) == pdf
    float pdf = 0;       // density at x
    size_t index = 0;    // cell
    float remapped = 0;  // u rescaled within the cell, in [0,1): may be used again
  };
  Sample sample(float u) const;
  float pdf(float x) const;
  /// Probability of a cell.
  float probability(size_t index) const;
  /// Sum of the weights as given.
  double sum() const { return sum_; }
  size_t size() const { return cdf_.empty() ? 0 : cdf_.size() - 1; }
  /// On the heap.
  size_t memory_bytes() const { return cdf_.capacity() * sizeof(float) + guide_.capacity() * sizeof(uint32_t); }

 private:
  size_t cell_of(float x) const;
  void make_guide(const CancelToken& cancel);
  std::vector<float> cdf_;  // size()+1 entries, 0 .. 1
  // For even parts of [0, 1], and for 1: the cell that holds its begin. A search in all of a large image's cells would
  // miss the caches at each step.
  std::vector<uint32_t> guide_;
  double sum_ = 0;
};

/// Rows are marginal, columns conditional.
class Distribution2D {
 public:
  Distribution2D() = default;
  /// Writes the weights of row y. Called once a row, by several threads.
  using FillRow = std::function<void(size_t y, std::span<float> row)>;
  Distribution2D(size_t width, size_t height, const FillRow& fill, const CancelToken& cancel = {});
  /// `weights` is row-major, row 0 at y = 0.
  Distribution2D(const std::vector<float>& weights, size_t width, size_t height, const CancelToken& cancel = {});

  struct Cell {
    size_t x = 0, y = 0;
    Vec2f remapped;  // u rescaled within the cell, in [0,1)^2: may be used again
  };
  Cell sample(const Vec2f& u) const;
  /// Probability of a cell.
  float probability(size_t x, size_t y) const;
  bool empty() const { return rows_.empty(); }
  /// On the heap.
  size_t memory_bytes() const;

 private:
  std::vector<Distribution1D> rows_;
  Distribution1D marginal_;
};

}  // namespace alabaster
