// How far a picture is from what it would converge to, estimated from its own samples. Squared differences between the
// halves of each pixel's samples tell how the variance has fallen; the law V = a / m + b / m^2 extends it to the number
// of samples taken. frame_error.md has the theory, the assumptions and the worst cases that were measured.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/convergence/pixel_group.h"
#include "core/film/film.h"

namespace alabaster {

/// Relative root mean square error of a frame: E^2 = mean over pixels of e^2 / (L^2 + f^2). e^2 is the squared error
/// averaged over red, green and blue, L the pixel's level (mean of the three over the 3 x 3 pixels around it), and the
/// floor f is kErrorFloor times the frame's mean level. E is noise alone: the bias of a setting is not in it.
inline constexpr double kErrorFloor = 0.05;

/// high over low of the widest interval that counts as knowledge of the error.
inline constexpr double kWidestInterval = 50;

struct FrameError {
  bool known = false;  // false: some pixel has less than two samples, or is not finite. The error of a black frame is
                       // known, and zero
  double relative_rmse = 0;  // not finite where some pixel is not
  /// The true error lies in this interval in 95 % of frames, if some sample has found every kind of light: no estimate
  /// can know of a path that no sample has taken.
  double low = 0, high = 0;
  /// False: the interval is so wide that it tells no more than that the error is at least `low`, or no noise is found.
  bool is_bounded() const { return known && low > 0 && high <= kWidestInterval * low; }
  /// The error with the doubt about it: noise that the estimate may lack counts as noise of its own.
  double with_doubt() const { return std::hypot(relative_rmse, std::max(0.0, high - relative_rmse)); }
};

/// Row-major, y-down.
struct NoiseImage {
  int width = 0, height = 0;
  std::vector<PixelNoise> pixels;
  int x0 = 0, y0 = 0;  // of the first pixel in the frame
};

/// Any thread. While a film is rendered, some tiles may be ahead of others. These run on all threads of the caller's
/// TBB arena, and no bit of their results depends on how many those are. They throw BuildCancelled.
NoiseImage film_noise(const Film& film, const CancelToken& cancel = {});
/// `groups`, one bit each: the error of their pixels, from these alone. In their levels, neighbours of the groups stand
/// for the others.
FrameError estimate_frame_error(const NoiseImage& image, const CancelToken& cancel = {},
                                uint32_t groups = kAllPixelGroups);
FrameError estimate_frame_error(const Film& film);
/// The e^2 / (L^2 + f^2) of each pixel of `groups`, whose mean is E^2, in the order of places_of(). Empty if they are
/// black or a pixel has less than two samples.
std::vector<double> relative_squared_errors(const NoiseImage& image, uint32_t groups = kAllPixelGroups);
/// The pixels of `groups`, by their places in the image.
std::vector<size_t> places_of(const NoiseImage& image, uint32_t groups);
/// Memory that film_noise() and estimate_frame_error() take while they run, for a frame whose pixels have at most
/// `most_samples`.
size_t frame_error_bytes(const PixelRect& window, uint64_t most_samples);

/// Samples per pixel, at most `most`, that bring the error to `target` if it is `error` after `done` samples. It is
/// taken to fall with the square root of their number.
uint32_t samples_for_error(uint32_t done, uint32_t most, double error, double target);

}  // namespace alabaster
