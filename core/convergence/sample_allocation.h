// Adaptive sampling: where a frame's samples go. After a pilot, the same for every pixel, the samples left are dealt
// out so that the frame's relative error (frame_error.h) becomes least in a given time: the sum of v / n under a given
// sum of n c is least for n ~ sqrt(v / c), v the relative variance of a sample and c its cost. Cost is counted in rays,
// for time would differ from run to run. A pixel's v and c are taken from the pixels about it that belong to another
// group (pixel_group.h), which keeps its mean unbiased.
#pragma once

#include <cstdint>
#include <vector>

#include "core/film/film.h"

namespace alabaster {

/// Samples of the pilot. A frame of fewer than twice as many is not worth dividing.
inline constexpr uint32_t kPilotSamples = 16;

class SampleAllocation {
 public:
  /// Every pixel the same.
  SampleAllocation() = default;
  /// `pilot`: a film whose pixels all have kPilotSamples. `rays`: that each pixel cost, row-major. `total`: samples per
  /// pixel that the frame will have on average, so that the pilot's are counted in; 0: not known, many.
  SampleAllocation(const Film& pilot, const std::vector<uint32_t>& rays, uint32_t total);

  /// How many samples pixel (row-major in the film's data window) has when the frame has `base` on average.
  uint32_t samples(size_t pixel, uint32_t base) const {
    if (rates_.empty() || base <= kPilotSamples) return base;
    return kPilotSamples + static_cast<uint32_t>(static_cast<float>(base - kPilotSamples) * rates_[pixel] + 0.5f);
  }

 private:
  std::vector<float> rates_;  // samples after the pilot for each of the frame's; their mean is one, or less where
                              // most of the frame is black: no pixel gets more than 8
};

}  // namespace alabaster
