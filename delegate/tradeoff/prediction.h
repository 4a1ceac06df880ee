// From a few short, small renders of a frame to what the whole frame will take to reach an error.
//
// The model: E^2(n, N) = (a + b / sqrt(N)) n^-p, n the samples per pixel, N the pixels of the frame. Of a pixel's noise
// a comes from light and material, whatever the pixel's size; b from the outlines and details in it, of which a coarse
// picture has more a pixel: an outline crosses a number of pixels that grows with sqrt(N), not with N. p is 1 for
// independent samples and somewhat more for stratified ones. In logarithms the three unknowns are linear: weighted
// least squares, with what other scenes showed of p and b as a prior, for probes of a second tell little about either.
#pragma once

#include <vector>

namespace alabaster::tradeoff {

/// One short render.
struct Probe {
  double pixels = 0;         // of the frame
  double samples = 0;        // per pixel, on average
  double wall = 0, cpu = 0;  // seconds of rendering
  double error = 0;          // relative RMSE (core/convergence/frame_error.h)
  double low = 0, high = 0;  // its 95 % interval
};

struct Range {
  double value = 0, low = 0, high = 0;  // 19 of 20 lie between low and high, if the model holds
};

struct Prediction {
  bool known = false;  // false: no probe was made
  bool noisy = false;  // false: no probe shows an error (a black picture): the first look is enough
  Range samples;       // per pixel, on average
  Range wall, cpu;     // seconds of rendering
};

/// A render looks at its error each time that it has an eighth more samples, in quarters of its pixels, of which the
/// slowest decides how long it takes: on average by this much longer than the error asks.
inline constexpr double kOvershoot = 1.12;

/// What `pixels` take to reach the relative RMSE `target` > 0. Of `probes` the last tells the cost of a sample and
/// counts as the most alike. `least_samples`: a render looks at its error no earlier.
Prediction predict(const std::vector<Probe>& probes, double pixels, double target, double least_samples);

}  // namespace alabaster::tradeoff
