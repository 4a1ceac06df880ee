// Which light to sample at a point, of those that take part in the choice: all but constant domes (light_set.h).
//
// Light i of importance w_i there (an estimate of the irradiance it can give, see light.h, times the mean of its scales
// for lobes) is chosen with probability
//   0.9 w_i / sum of w + 0.1 / n,  n the number of lights with w > 0; 0 if w_i = 0 or the light is a constant dome.
// The uniform part is defensive (Hesterberg 1995, "Weighted Average Importance Sampling and Defensive Mixture
// Distributions"): where the estimate errs because of an occluder or a cosine, no light starves.
//
// The cost is O(n) per point. LightTree has less for very many lights.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/light/light.h"

namespace alabaster {

/// Random numbers have 24 bits: probabilities are whole multiples of 1 / kChoiceSteps.
inline constexpr uint32_t kChoiceSteps = uint32_t(1) << 24;

/// The choice at one point; allocates nothing. choose() takes each light exactly as often as its probability says. Up
/// to a million lights, the probability is positive wherever w is. A set of one light is not weighed: it has
/// probability 1. It must not be a constant dome.
class LightChoice {
 public:
  /// Keeps references. `scales`: beside the lights; empty: all are 1.
  LightChoice(const std::vector<Light>& lights, const std::vector<LobeScales>& scales, const Vec3f& p);

  /// Any i; fastest where i does not decrease from call to call.
  float probability(size_t i);

  struct Chosen {
    size_t index = 0;
    float probability = 0;
  };
  /// Empty if no light gives anything at p. Call it before probability().
  std::optional<Chosen> choose(float u);

 private:
  double importance(size_t i) const;
  void advance();
  float probability_of_current() const;

  static constexpr size_t kKept = 32;

  const std::vector<Light>& lights_;
  const std::vector<LobeScales>& scales_;
  Vec3f p_;
  std::array<double, kKept> kept_;  // importances of the first lights; those of the rest are computed again
  double total_ = 0;
  size_t shining_ = 0;  // n
  /// Goes through the lights in order.
  struct Cursor {
    size_t next = 0;              // the light after the current one
    uint32_t begin = 0, end = 0;  // random numbers that choose the current light, in steps of 2^-24
    size_t shining = 0;           // lights before `next` with w > 0
    double running = 0;           // sum of their w
  } cursor_;
};

}  // namespace alabaster
