// Predicts the cost of rendering a frame to an error from a few short, small renders of it.
//
// The model: E^2(n, N) = (a + b / sqrt(N)) n^-p, with n samples per pixel and N pixels in the frame. The term a is the
// noise of light and material, whatever the pixel's size. The term b is the noise of outlines and details, of which
// each pixel of a coarse picture has more: the number of pixels that an outline crosses grows with sqrt(N), not with N.
// p is 1 for independent samples and somewhat more for stratified ones. E is the error of quarters of the pixels, which
// end a render and whose levels are less even than the frame's. The three unknowns are linear in logarithms and found
// by weighted least squares. Other scenes give the prior of p and b, because probes of a second say little about
// either.
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
  double groups = 1;         // the error of quarters of the pixels (core/convergence/group_stopping.h) over `error`
};

struct Range {
  double value = 0, low = 0, high = 0;  // 19 of 20 lie between low and high, if the model holds
};

struct Prediction {
  bool known = false;  // false: no probe was made
  bool noisy = false;  // false: no probe shows an error (a black picture), and the first estimate ends the render
  Range samples;       // per pixel, on average
  Range wall, cpu;     // seconds of rendering
};

/// A render estimates its error each time it has an eighth more samples, and ends when it is at the target with the
/// doubt about it. In the median over eleven scenes it takes longer than the error requires by this factor
/// (testenv/statistical/results/calibration.md, "Prediction").
inline constexpr double kOvershoot = 1.2;

/// Predicts the cost of reaching the relative RMSE `target` > 0 with `pixels` pixels. The last of `probes` gives the
/// cost of a sample and counts as the most similar to the frame. A render does not estimate its error before
/// `least_samples`.
Prediction predict(const std::vector<Probe>& probes, double pixels, double target, double least_samples);

}  // namespace alabaster::tradeoff
