// How far a picture is from what it would converge to, told by the picture itself.
//
// A pixel's samples are the first n of one scrambled sequence (core/sampling/pixel_sampler.h). At every node of the
// binary tree over the sample indices the scrambling may swap the two branches with equal chance, so all blocks of
// 2^k samples that begin at a multiple of 2^k look alike, and the covariance of two samples depends only on the highest
// bit in which their indices differ. With V(m) the variance of the mean of the first m samples, the two halves of the
// first 2m have means a and b with
//   E (a - b)^2 / 4 = V(m) - V(2m),    V(2m) = (V(m) + cov(a, b)) / 2.
// What is left to assume is how V falls on: as a / m + b / m^2, a and b from the differences at three sizes.
// Where noise rules, E^2 is right within some per cent. It is worst where nothing but stratification is left, for
// example a floor under an even sky: there V falls in uneven steps, and E has been seen up to 1.6 times too large.
#pragma once

#include <vector>

#include "core/film/film.h"

namespace alabaster {

/// Relative root mean square error over a frame: E^2 = mean over pixels of e^2 / (L^2 + f^2), where e^2 is the squared
/// error averaged over red, green and blue, L the pixel's level (mean of the three over the 3 x 3 pixels about it) and
/// the floor f = kErrorFloor times the frame's mean level. Noise alone: what a setting biases is not in it.
inline constexpr double kErrorFloor = 0.05;

struct FrameError {
  bool known = false;  // false: not every pixel has two samples yet. A black frame has no noise
  double relative_rmse = 0;
  /// 95 % of the frames that report this interval have their true error in it, if no light was missed altogether: what
  /// no sample has met yet, no estimate can know.
  double low = 0, high = 0;
};

/// Pixels in rows.
struct NoiseImage {
  int width = 0, height = 0;
  std::vector<PixelNoise> pixels;
};

/// Tiles that are being rendered may be ahead of others. Any thread.
NoiseImage film_noise(const Film& film);
FrameError estimate_frame_error(const NoiseImage& image);
/// What each pixel adds to E^2 (times their number); empty if the frame is black or a pixel has less than two samples.
std::vector<double> relative_squared_errors(const NoiseImage& image);
FrameError estimate_frame_error(const Film& film);
/// Memory that it takes while it runs.
size_t frame_error_bytes(const PixelRect& window);

/// Samples per pixel that bring the error from `error`, after `done` of them, to `target`, at most `most`. The error
/// falls with the square root of their number.
uint32_t samples_for_error(uint32_t done, uint32_t most, double error, double target);

/// E^2 of `image` against `reference` (RGBA rows as Film::resolve_float gives them), by the same definition with the
/// levels of the reference. For tests and measurements.
double relative_mse(const std::vector<float>& image, const std::vector<float>& reference, int width, int height);

}  // namespace alabaster
