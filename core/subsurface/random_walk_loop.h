// The walk itself, over anything that can trace a segment: a mesh in random_walk.cpp, bodies with a closed-form answer
// in the tests. Throughput is carried in double precision: at A = 0.9999 an event takes 2e-9 of it, which float would
// lose.
#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "core/sampling/warp.h"
#include "core/subsurface/random_walk.h"

namespace alabaster {

/// One value per colour channel, in double.
using ChannelValues = std::array<double, 3>;

inline double max_value(const ChannelValues& v) {
  return std::max(v[0], std::max(v[1], v[2]));
}

/// A medium as the loop wants it: alpha in double, from whichever of alpha and 1 - alpha carries more digits, and each
/// channel's extinction above the clearest one's. Ratios of transmittances need no more than that excess: it saves an
/// exponential where channels differ and all of them where they are alike.
struct WalkMedium {
  ChannelValues sigma_t{}, alpha{}, excess{};

  explicit WalkMedium(const Medium& medium) {
    double clearest = std::numeric_limits<double>::infinity();
    for (int c = 0; c < 3; ++c) {
      const auto i = static_cast<size_t>(c);
      sigma_t[i] = medium.sigma_t[c];
      alpha[i] = medium.alpha[c] < 0.5f ? medium.alpha[c] : 1.0 - medium.one_minus_alpha[c];
      if (medium.active[c]) clearest = std::min(clearest, sigma_t[i]);
    }
    for (size_t c = 0; c < 3; ++c) excess[c] = medium.active[c] ? sigma_t[c] - clearest : 0;
  }
};

/// Distance sampling of one segment (Chiang, Kutz, Burley 2016, section 3): a channel is chosen with probability w_c, a
/// distance from p_c(t) = sigma_c exp(-sigma_c t), and the estimators of all channels share it by the balance
/// heuristic. The pdf of scattering at t is sum_c w_c p_c(t); the probability of passing a surface at t is sum_c w_c
/// exp(-sigma_c t).
///
/// Paper's weights, w ~ T alpha: the sum of T after a scatter equals the sum of T alpha before it. w ~ T: the sum of T
/// never grows, neither by a scatter nor by an exit. Neither pdf can underflow: the chosen channel's exp(-sigma t) is
/// at least 2^-24, the smallest number that it was drawn from.
class ChromaticSegment {
 public:
  ChromaticSegment(const WalkMedium& medium, const ChannelValues& throughput, WalkWeights weights)
      : medium_(medium), throughput_(throughput), weights_(throughput) {
    if (weights == WalkWeights::throughput_times_albedo) {
      for (size_t c = 0; c < 3; ++c) weights_[c] *= medium.alpha[c];
      // Where nothing scatters the paper's weights vanish, yet light crosses a thin body: then w ~ T.
      if (!(sum() >= std::numeric_limits<float>::min())) weights_ = throughput;
    }
    sum_ = sum();
  }

  /// World distance to the next event; infinite if the chosen channel has no extinction.
  float sample_distance(Rng& rng) const {
    const size_t c = choose_channel(rng.uniform() * sum_);
    const float optical_depth = -std::log(1 - rng.uniform());
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
  double sum() const { return weights_[0] + weights_[1] + weights_[2]; }

  /// exp(-sigma_t t) up to a common factor.
  ChannelValues relative_transmittance(double t) const {
    ChannelValues result{};
    for (size_t c = 0; c < 3; ++c) result[c] = medium_.excess[c] > 0 ? std::exp(-medium_.excess[c] * t) : 1;
    return result;
  }

  size_t choose_channel(double u) const {
    size_t chosen = 0;
    for (size_t c = 0; c < 3; ++c) {
      if (!(weights_[c] > 0)) continue;
      chosen = c;
      if (u < weights_[c]) break;
      u -= weights_[c];
    }
    return chosen;
  }

  /// T_c f_c / sum_j w_j f_j, w normalised.
  ChannelValues combine(const ChannelValues& f) const {
    const double pdf = weights_[0] * f[0] + weights_[1] * f[1] + weights_[2] * f[2];
    ChannelValues result{};
    if (pdf > 0)
      for (size_t c = 0; c < 3; ++c) result[c] = throughput_[c] * (f[c] * sum_ / pdf);
    return result;
  }

  const WalkMedium& medium_;
  ChannelValues throughput_, weights_;
  double sum_ = 0;
};

/// True with probability q, exact to 2^-56: survival is as near to one as 1 - 2e-9 and is asked a million times.
inline bool survives(double q, Rng& rng) {
  const double scaled = q * 0x1p32;
  const double whole = std::floor(scaled);
  const double drawn = rng.next();
  return drawn != whole ? drawn < whole : rng.uniform() < scaled - whole;
}

template <class Hit>
struct WalkLoopExit {
  Hit hit;
  Vec3f direction;  // of the last segment
  ChannelValues throughput{};
  uint32_t events = 0;
};

/// Walks from where `tracer` stands until the surface is met. A tracer keeps the position and has:
///   Hit                                      what it says of a surface point
///   bool intersect(dir, tmax, Hit*)          nearest surface within tmax, both in world units
///   double exit_distance(hit)                distance through the medium to it
///   bool advance(dir, t)                     moves; false if that left the body without crossing its surface
/// `throughput` is what the path brings to the walk, relative to its largest channel: the weights go on from it, as the
/// paper's do, so that no walk follows a channel that the path has already lost.
/// Segment is ChromaticSegment; tests put a wrong one here to see that they notice.
template <class Segment = ChromaticSegment, class Tracer>
std::optional<WalkLoopExit<typename Tracer::Hit>> run_walk_loop(Tracer& tracer, Vec3f direction, const Medium& medium,
                                                                const WalkSettings& settings, Rng& rng,
                                                                RenderCounters& counters,
                                                                ChannelValues throughput = {1, 1, 1}) {
  const WalkMedium walk_medium(medium);
  for (size_t c = 0; c < 3; ++c)
    if (!medium.active[c]) throughput[c] = 0;
  const auto note_weight = [&] {
    counters.max_walk_weight = std::max(counters.max_walk_weight, max_value(throughput));
  };
  ++counters.walks;
  if (!(max_value(throughput) > 0)) return std::nullopt;
  const double entering = throughput[0] + throughput[1] + throughput[2];

  for (uint32_t events = 0; events < settings.safety_cap; ++events) {
    const Segment segment(walk_medium, throughput, settings.weights);
    const float t = segment.sample_distance(rng);
    ++counters.walk_rays;
    typename Tracer::Hit hit{};
    if (tracer.intersect(direction, t, &hit)) {
      throughput = segment.exit_throughput(tracer.exit_distance(hit));
      note_weight();
      ++counters.walk_exits;
      return WalkLoopExit<typename Tracer::Hit>{hit, direction, throughput, events};
    }
    if (!(t < std::numeric_limits<float>::infinity()) || !tracer.advance(direction, t)) {
      ++counters.walk_lost;
      const ChannelValues lost = std::isfinite(t) ? segment.scatter_throughput(t) : segment.exit_throughput(t);
      counters.walk_lost_energy += (lost[0] + lost[1] + lost[2]) / entering;
      return std::nullopt;
    }
    ++counters.walk_events;
    throughput = segment.scatter_throughput(t);
    note_weight();
    // Roulette on the largest channel: unbiased, and where alpha < 1 it is what ends the walk.
    const double q = max_value(throughput);
    if (q < 1) {
      if (!survives(q, rng)) {
        ++counters.walk_roulette_ends;
        return std::nullopt;
      }
      for (double& channel : throughput) channel /= q;
    }
    const float u = rng.uniform();
    direction = sample_uniform_sphere({u, rng.uniform()});
  }
  ++counters.walk_safety_cap;
  return std::nullopt;
}

}  // namespace alabaster
