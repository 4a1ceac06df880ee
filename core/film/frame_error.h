// How far a picture is from what it would converge to, told by the picture itself.
//
// Where it is asked (Aov::error, RenderSettings::target_error) a pixel's even and odd samples are two independent sets.
// Of their means a and b the picture shows (a + b) / 2, whose variance is estimated without bias by (a - b)^2 / 4. One
// pixel tells little; thousands tell much. Two sets are less evenly spread than one of twice the size: what asks for no
// error does not pay for it.
#pragma once

#include "core/film/film.h"

namespace alabaster {

/// Relative root mean square error over a frame: E^2 = mean over pixels of e^2 / (L^2 + f^2), where e^2 is the squared
/// error averaged over red, green and blue, L the pixel's level (mean of the three over the 3 x 3 pixels about it) and
/// the floor f = kErrorFloor times the frame's mean level. Noise alone: what a setting biases is not in it.
inline constexpr double kErrorFloor = 0.05;

struct FrameError {
  bool known = false;  // false: it was not asked, or not every pixel has two samples yet. A black frame has no noise
  double relative_rmse = 0;
  /// 95 % of the frames that report this interval have their true error in it, if no light was missed altogether: what
  /// no sample has met yet, no estimate can know.
  double low = 0, high = 0;
};

/// Tiles that are being rendered may be ahead of others. Any thread.
FrameError estimate_frame_error(const Film& film);

/// E^2 of `image` against `reference` (RGBA rows as Film::resolve_float gives them), by the same definition with the
/// levels of the reference. For tests and measurements.
double relative_mse(const std::vector<float>& image, const std::vector<float>& reference, int width, int height);

}  // namespace alabaster
