// The levels of pixels, which their errors are relative to. Internal to this room.
#pragma once

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
/// The range of each pixel. These two throw BuildCancelled.
std::vector<LevelRange> level_ranges(const PixelSet& pixels, const CancelToken& cancel);
/// The floor f; 0 if all pixels are black, and not finite if one is not.
double error_floor(const PixelSet& pixels, const CancelToken& cancel);
/// Memory for each pixel that level_ranges() takes besides its result.
inline constexpr size_t kLevelBytes = 4 * sizeof(double);

}  // namespace alabaster
