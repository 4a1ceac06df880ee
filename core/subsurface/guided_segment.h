// Guided segments and jumps: one-sample MIS (balance heuristic) over channel x technique, where a technique is plain,
// towards the surface that the walk entered through, or away from it, towards the opposite one.
//
// With mu the cosine of the direction to the entry surface's outward normal and x = 1/nu0 of the channel, the guided
// densities beside the plain ones, 1/(4 pi) per solid angle and sigma_t exp(-sigma_t t) per distance (dwivedi.h), are
//   direction         a/(1 - x mu)                   a = x/atanh(x), alpha of the mode
//   scattering at t   (1 - x mu) exp(kappa mu t)     kappa = sigma_t x
//   passing t         exp(kappa mu t)
// so a guided event costs one exponential: of the depth that it gains or loses. Away from the entry surface mu changes
// its sign.
#pragma once

#include "core/math/elementary.h"
#include "core/math/frame.h"
#include "core/sampling/warp.h"
#include "core/subsurface/chromatic_segment.h"

namespace alabaster {

/// Probabilities of the techniques at one vertex of a walk, given the channel; they sum to one.
struct GuideShares {
  ChannelValues plain{1, 1, 1}, towards{}, away{};
};

/// Where a walk stands between the surface that it entered through and the opposite one.
class WalkGuide {
 public:
  /// Least share of the plain technique: it protects where the guess is wrong.
  static constexpr double kLeastPlain = 0.25;
  /// The sum of the throughputs never exceeds this: an event of plain share p can at most divide the sum by p, and p is
  /// never less than the sum over this.
  static constexpr double kLargestSum = 30;

  explicit WalkGuide(const Vec3f& inward) : outward_(frame_from_normal(-inward)) {}

  const Frame& outward() const { return outward_; }
  double depth() const { return depth_; }
  void advance(const Vec3f& direction, double t) { depth_ -= static_cast<double>(dot(direction, outward_.n)) * t; }
  /// World distance of the opposite surface from the entry surface; infinite until known.
  void set_thickness(double thickness) { thickness_ = thickness; }

  GuideShares shares(const DiffusionModes& modes, const ChannelValues& throughput) const {
    const double plain = std::min(1.0, std::max(kLeastPlain, sum_of(throughput) / kLargestSum));
    GuideShares shares;
    for (size_t c = 0; c < 3; ++c) {
      if (!modes.guided[c]) continue;
      shares.plain[c] = plain;
      // Light that a particle here will still bring out falls as exp(-kappa z) towards the one side and as
      // exp(-kappa (L-z)) towards the other: their ratio divides the guided share.
      if (thickness_ < std::numeric_limits<double>::infinity())
        shares.away[c] = (1 - plain) / (1 + std::exp(modes.kappa[c] * (thickness_ - 2 * depth_)));
      shares.towards[c] = 1 - plain - shares.away[c];
    }
    return shares;
  }

 private:
  Frame outward_;
  double depth_ = 0;
  double thickness_ = std::numeric_limits<double>::infinity();
};

enum class GuideTechnique { plain, towards, away };

inline GuideTechnique draw_technique(const GuideShares& shares, size_t channel, double u) {
  if (!(shares.plain[channel] < 1)) return GuideTechnique::plain;
  if (u < shares.towards[channel]) return GuideTechnique::towards;
  return u < shares.towards[channel] + shares.away[channel] ? GuideTechnique::away : GuideTechnique::plain;
}

inline Vec3f direction_at(const Frame& frame, double cosine, float u) {
  const auto mu = static_cast<float>(cosine);
  const float r = safe_sqrt(1 - mu * mu);
  const auto [sine, cosine_of_azimuth] = quick_sine_cosine_turns(u);
  return frame.to_world({r * cosine_of_azimuth, r * sine, mu});
}

/// The input of both kinds of guided move.
struct GuidedState {
  const WalkMedium& medium;
  const WalkGuide& guide;
};

class GuidedSegment {
 public:
  GuidedSegment(const GuidedState& state, const ChannelValues& throughput)
      : state_(state),
        throughput_(throughput),
        choice_(throughput),
        shares_(state.guide.shares(state.medium.modes, throughput)) {}

  /// World distance to the next event; infinite if the chosen channel has no extinction. Chooses the direction, too,
  /// unless it is the walk's first, which the entry lobe has chosen: then only distances are guided.
  float sample(bool first, Vec3f* direction, std::array<float, 4> u) {
    const size_t c = choice_.draw(&u[2]);
    const GuideTechnique technique = draw_technique(shares_, c, u[2]);
    const Frame& frame = state_.guide.outward();
    const DwivediMode& mode = state_.medium.modes.mode[c];
    first_ = first;
    if (!first) {
      double cosine = 0;
      if (technique == GuideTechnique::plain)
        cosine = 1 - 2 * static_cast<double>(u[0]);
      else
        cosine = sample_dwivedi(u[0], mode) * (technique == GuideTechnique::towards ? 1 : -1);
      *direction = direction_at(frame, cosine, u[1]);
    }
    mu_ = std::min(std::max(static_cast<double>(dot(*direction, frame.n)), -1.0), 1.0);
    const double along = technique == GuideTechnique::plain ? 0 : technique == GuideTechnique::towards ? mu_ : -mu_;
    rate_ = state_.medium.sigma_t[c] * (1 - mode.x * along);
    const float optical_depth = -std::log(1 - u[3]);
    if (!(rate_ > 0)) return std::numeric_limits<float>::infinity();
    return static_cast<float>(optical_depth / rate_);
  }

  /// Throughput after scattering at distance t (finite).
  ChannelValues scatter_throughput(double t) const { return combine(t, true); }
  /// Throughput after crossing distance t (finite) to a surface.
  ChannelValues exit_throughput(double t) const { return combine(t, false); }

 private:
  /// T_c f_c / sum_j w_j p_j. Exponents are taken relative to that of the distance drawn, which is at least 2^-24: none
  /// overflows, and what underflows is too little to matter beside it.
  ChannelValues combine(double t, bool scatters) const {
    ChannelValues result{};
    double pdf = 0;
    for (size_t c = 0; c < 3; ++c) {
      if (!(throughput_[c] > 0)) continue;
      const double exponent = (rate_ - state_.medium.sigma_t[c]) * t, tilt = state_.medium.modes.kappa[c] * mu_ * t;
      const double extinction = scatters ? state_.medium.sigma_t[c] : 1;
      const double plain = exponential(exponent);
      double mixture = shares_.plain[c] * plain;
      if (shares_.towards[c] > 0)
        mixture += shares_.towards[c] * guided_factor(c, mu_, scatters) * exponential(exponent + tilt);
      if (shares_.away[c] > 0)
        mixture += shares_.away[c] * guided_factor(c, -mu_, scatters) * exponential(exponent - tilt);
      pdf += choice_.weights[c] * extinction * mixture;
      result[c] = throughput_[c] * extinction * plain * (scatters ? state_.medium.alpha[c] : 1);
    }
    const double scale = pdf > 0 ? choice_.sum / pdf : 0;
    for (double& channel : result) channel *= scale;
    return result;
  }

  /// Guided over plain density without the exponential.
  double guided_factor(size_t c, double mu, bool scatters) const {
    const DwivediMode& mode = state_.medium.modes.mode[c];
    const double distance = 1 - mode.x * mu;
    if (first_) return scatters ? distance : 1;
    return scatters ? mode.alpha : mode.alpha / distance;
  }

  /// Float is precise enough for weights that a walk multiplies some ten times, and faster.
  static double exponential(double x) { return quick_exp(static_cast<float>(std::max(x, -1000.0))); }

  GuidedState state_;
  ChannelValues throughput_;
  ChannelChoice choice_;
  GuideShares shares_;
  bool first_ = false;
  double mu_ = 0, rate_ = 0;
};

/// A jump to the sphere of that radius about the walk's position, with no surface within: a sphere step
/// (random_walk.md). The plain technique lands uniformly, the guided ones with density ~ exp(+-kappa mu radius), as the
/// light that the landing point will bring out. Returns the direction and updates the throughput.
inline Vec3f guided_jump(const GuidedState& state, double radius, ChannelValues* throughput, std::array<float, 4> u) {
  const ChannelChoice choice(*throughput);
  const GuideShares shares = state.guide.shares(state.medium.modes, *throughput);
  const size_t chosen = choice.draw(&u[2]);
  const GuideTechnique technique = draw_technique(shares, chosen, u[2]);
  const double reach = technique == GuideTechnique::plain ? 0 : state.medium.modes.kappa[chosen] * radius;
  const double cosine = sample_exponential_cosine(u[0], reach) * (technique == GuideTechnique::away ? -1 : 1);
  double pdf = 0;
  for (size_t c = 0; c < 3; ++c) {
    if (!((*throughput)[c] > 0)) continue;
    const double x = state.medium.modes.kappa[c] * radius;
    double mixture = shares.plain[c];
    if (shares.towards[c] > 0) mixture += shares.towards[c] * exponential_cosine_factor(cosine, x);
    if (shares.away[c] > 0) mixture += shares.away[c] * exponential_cosine_factor(-cosine, x);
    pdf += choice.weights[c] * mixture;
    (*throughput)[c] *= x_over_sinh(x);
  }
  for (double& channel : *throughput) channel *= choice.sum / pdf;
  return direction_at(state.guide.outward(), cosine, u[1]);
}

}  // namespace alabaster
