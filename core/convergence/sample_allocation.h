// Adaptive sampling: how a frame's samples are allocated to pixels. A pilot gives every pixel the same number. The rest
// is allocated so that the frame's relative error (frame_error.h) becomes least in a given time: with v a pixel's
// relative variance per sample and c the cost of one, the sum of v / n under a given sum of n c is least for
// n ~ sqrt(v / c) (Neyman 1934, optimum allocation). Cost is counted in rays, since time differs from run to run. v and
// c are estimated from nearby pixels of other groups (pixel_group.h), so that the mean of a pixel stays unbiased.
#pragma once

#include <cstdint>
#include <vector>

#include "core/film/film.h"

namespace alabaster {

/// Samples per pixel of the pilot. A frame with fewer than twice as many is rendered evenly.
inline constexpr uint32_t kPilotSamples = 16;
/// Bounds of a pixel's rate: the pilot is too small to trust that a pixel has no noise, or that a rare path is not
/// rare.
inline constexpr float kLeastSampleRate = 0.125f, kLargestSampleRate = 8;

class SampleAllocation {
 public:
  /// All pixels have the same number.
  SampleAllocation() = default;
  /// `pilot`: a film whose pixels all have kPilotSamples. `rays`: cost of each pixel of the pilot, row-major. `total`:
  /// mean samples per pixel of the whole frame, the pilot's included; 0: not known, many.
  SampleAllocation(const Film& pilot, const std::vector<uint32_t>& rays, uint32_t total);
  /// From the rates() of another, within the bounds above.
  explicit SampleAllocation(std::vector<float> rates) : rates_(std::move(rates)) {}
  /// Empty: all pixels have the same number.
  const std::vector<float>& rates() const { return rates_; }

  /// Samples of `pixel` (row-major in the film's data window) when the frame has `base` per pixel.
  uint32_t samples(size_t pixel, uint32_t base) const {
    if (rates_.empty() || base <= kPilotSamples) return base;
    return kPilotSamples + static_cast<uint32_t>(static_cast<float>(base - kPilotSamples) * rates_[pixel] + 0.5f);
  }

 private:
  // Samples of each pixel after the pilot, per sample of the frame, within the bounds. Their mean is one, or less where
  // most of the frame is black, since a pixel gets no more than 8.
  std::vector<float> rates_;
};

/// Bytes of the rates of a frame, and those that the constructor takes besides while the frame's NoiseImage is held.
size_t sample_allocation_bytes(const PixelRect& window);
size_t making_allocation_bytes(const PixelRect& window);

}  // namespace alabaster
