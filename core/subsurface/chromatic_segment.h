// Distance sampling where extinction depends on the channel: Chiang, Kutz, Burley 2016, section 3.
#pragma once

#include "core/sampling/pixel_sampler.h"
#include "core/subsurface/random_walk.h"

namespace alabaster {

/// Probabilities of the channels, not normalised: w ~ T.
struct ChannelChoice {
  ChannelValues weights;
  double sum = 0;

  explicit ChannelChoice(const ChannelValues& throughput) : weights(throughput), sum(sum_of(weights)) {}

  /// `u` is left uniform on [0, 1), independent of the choice.
  size_t draw(float* u_channel) const {
    double u = static_cast<double>(*u_channel) * sum;
    size_t chosen = 0;
    for (size_t c = 0; c < 3; ++c) {
      if (!(weights[c] > 0)) continue;
      chosen = c;
      if (u < weights[c]) break;
      u -= weights[c];
    }
    if (weights[chosen] > 0) *u_channel = std::min(static_cast<float>(u / weights[chosen]), kOneMinusEpsilon);
    return chosen;
  }
};

/// One segment: a channel is chosen with probability w_c, a distance from p_c(t) = sigma_c exp(-sigma_c t), and the
/// estimators of all channels share it by the balance heuristic. The pdf of scattering at t is sum_c w_c p_c(t); the
/// probability of passing a surface at t is sum_c w_c exp(-sigma_c t).
///
/// With w ~ T the sum of T never grows, neither by a scatter nor by an exit; with the paper's w ~ T alpha it grows at
/// exits. The pdf cannot underflow: the chosen channel's exp(-sigma t) is at least 2^-24, the smallest number that it
/// was drawn from.
class ChromaticSegment {
 public:
  ChromaticSegment(const WalkMedium& medium, const ChannelValues& throughput)
      : medium_(medium), throughput_(throughput), choice_(throughput) {}

  /// World distance to the next event; infinite if the chosen channel has no extinction.
  float sample_distance(Vec2f u) const {
    const size_t c = choice_.draw(&u.x);
    const float optical_depth = -std::log(1 - u.y);
    if (!(medium_.sigma_t[c] > 0)) return std::numeric_limits<float>::infinity();
    return static_cast<float>(optical_depth / medium_.sigma_t[c]);
  }

  /// Throughput after scattering at distance t (finite).
  ChannelValues scatter_throughput(double t) const {
    ChannelValues collided = relative_transmittance(t);
    for (size_t c = 0; c < 3; ++c) collided[c] *= medium_.sigma_t[c];
    ChannelValues result = combine(collided);
    for (size_t c = 0; c < 3; ++c) result[c] *= medium_.alpha[c];
    return result;
  }

  /// Throughput after crossing distance t (finite) to a surface.
  ChannelValues exit_throughput(double t) const { return combine(relative_transmittance(t)); }

 private:
  /// exp(-sigma_t t) up to a common factor.
  ChannelValues relative_transmittance(double t) const {
    ChannelValues result{};
    for (size_t c = 0; c < 3; ++c) result[c] = medium_.excess[c] > 0 ? std::exp(-medium_.excess[c] * t) : 1;
    return result;
  }

  /// T_c f_c / sum_j w_j f_j, w normalised.
  ChannelValues combine(const ChannelValues& f) const {
    const ChannelValues& w = choice_.weights;
    const double pdf = w[0] * f[0] + w[1] * f[1] + w[2] * f[2];
    ChannelValues result{};
    if (pdf > 0)
      for (size_t c = 0; c < 3; ++c) result[c] = throughput_[c] * (f[c] * choice_.sum / pdf);
    return result;
  }

  const WalkMedium& medium_;
  ChannelValues throughput_;
  ChannelChoice choice_;
};

}  // namespace alabaster
