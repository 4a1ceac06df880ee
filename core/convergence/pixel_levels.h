// The levels of pixels, which their errors are relative to. Internal to this room.
#pragma once

#include <algorithm>
#include <functional>
#include <vector>

#include "core/convergence/frame_error.h"

namespace alabaster {

/// Pixels whose errors are estimated together: those of some groups of an image, which must outlive it.
class PixelSet {
 public:
  PixelSet(const NoiseImage& image, uint32_t groups) : image_(image), groups_(groups) {
    if (groups != kAllPixelGroups) places_ = places_of(image, groups);
  }
  size_t size() const { return groups_ == kAllPixelGroups ? image_.pixels.size() : places_.size(); }
  const PixelNoise& operator[](size_t i) const { return image_.pixels[place(i)]; }
  const NoiseImage& image() const { return image_; }
  uint32_t groups() const { return groups_; }
  int x(size_t i) const { return int(place(i) % size_t(image_.width)); }
  int y(size_t i) const { return int(place(i) / size_t(image_.width)); }
  /// The first of the pixels at this place of the image or behind it.
  size_t first_from(size_t place) const {
    if (groups_ == kAllPixelGroups) return place;
    return size_t(std::lower_bound(places_.begin(), places_.end(), place) - places_.begin());
  }

 private:
  size_t place(size_t i) const { return groups_ == kAllPixelGroups ? i : places_[i]; }
  const NoiseImage& image_;
  uint32_t groups_;
  std::vector<size_t> places_;
};

/// The range of the level L of a pixel, from its surroundings.
struct LevelRange {
  double low = 0, high = 0;
  double excess = 0;  // of its own level over its brightest neighbour's
};
/// Takes the range of pixel i of a set. Calls with the same block come one after the other, in one order.
using TakeLevel = std::function<void(size_t block, size_t i, const LevelRange& range)>;
/// Blocks of pixels near each other. Ranges are computed block by block and not kept: they would be a third of a
/// frame's memory. These two throw BuildCancelled.
size_t level_blocks(const NoiseImage& image);
void visit_levels(const PixelSet& pixels, const TakeLevel& take, const CancelToken& cancel);
/// The floor f; 0 if all pixels are black, and not finite if one is not.
double error_floor(const PixelSet& pixels, const CancelToken& cancel);

}  // namespace alabaster
