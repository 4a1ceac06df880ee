// Which light to sample at a point.
//
// Light i of importance w_i there (an estimate of the irradiance it can give, see light.h) is chosen with probability
//   0.9 w_i / sum of w + 0.1 / n,  n the number of lights with w > 0; 0 if w_i = 0.
// The uniform part is defensive (Hesterberg 1995, "Weighted Average Importance Sampling and Defensive Mixture
// Distributions"): where the estimate errs because of an occluder or a cosine, no light starves.
//
// Costs O(n) per point, which a light tree behind the same three calls could lower for scenes of very many lights.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/light/light.h"

namespace alabaster {

/// The choice at one point; allocates nothing. Random numbers have 24 bits, so the probabilities are whole multiples of
/// 2^-24 and exactly how often choose() takes a light (and positive where w is, up to a million lights). A set of one
/// light is not weighed: it has probability 1.
class LightChoice {
 public:
  /// Keeps a reference to `lights`.
  LightChoice(const std::vector<Light>& lights, const Vec3f& p);

  /// Goes through the lights in order: i must not decrease from call to call.
  float probability(size_t i);

  struct Chosen {
    size_t index = 0;
    float probability = 0;
  };
  /// Empty if no light gives anything at p. Instead of probability(), not after it.
  std::optional<Chosen> choose(float u);

 private:
  double importance(size_t i) const;
  void advance();

  static constexpr size_t kKept = 32;

  const std::vector<Light>& lights_;
  Vec3f p_;
  std::array<double, kKept> kept_;  // importances of the first lights; those of the rest are computed again
  double total_ = 0;
  size_t shining_ = 0;  // n
  // The range of random numbers, in steps of 2^-24, of light next_ - 1; and what came before next_.
  uint32_t begin_ = 0, end_ = 0;
  size_t next_ = 0, shone_ = 0;
  double running_ = 0;
};

}  // namespace alabaster
