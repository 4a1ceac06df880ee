// The walk itself, over anything that can trace a segment: bodies in random_walk.cpp, shapes with a closed-form answer
// in the tests. random_walk.md derives the two shortcuts, guiding and sphere steps; each is compiled into loops of its
// own, so that a walk never asks for a shortcut that it does not take. Throughput is carried in double precision: at A
// = 0.9999 an event takes 2e-9 of it, which float would lose.
#pragma once

#include <optional>

#include "core/diagnostics/check.h"
#include "core/subsurface/chromatic_segment.h"
#include "core/subsurface/guided_segment.h"
#include "core/subsurface/half_space_twin.h"
#include "core/subsurface/henyey_greenstein.h"
#include "core/subsurface/random_walk.h"

namespace alabaster {

/// Mean free paths that a sphere step keeps from every surface. Less is faster and biased; at 1.5
/// half-spaces obtain 1.4e-4 +- 0.5e-4 too much (A = 0.99; testenv/statistical/results/walk_efficiency.md).
inline constexpr double kSphereMargin = 1.5;

/// True with probability q, exact to 2^-56: survival is as near to one as 1 - 2e-9 and is asked a million times.
inline bool survives(double q, Rng& rng) {
  const double scaled = q * 0x1p32;
  const double whole = std::floor(scaled);
  const double drawn = rng.next();
  return drawn != whole ? drawn < whole : rng.uniform() < scaled - whole;
}

/// Roulette ends walks whose throughput has fallen below the first of these, relative to the start, and lifts survivors
/// to the second. A guided walk loses throughput at every event and hardly any noise: roulette from the start would put
/// back the noise that guiding has taken away (testenv/benchmark/results/sampling.md).
inline constexpr double kWalkRouletteBelow = 0.25, kLiftedTo = 0.5;

/// A walk asks after as many events whether it is cancelled, which is after a millisecond or less.
inline constexpr uint32_t kEventsPerLook = 4096;

/// The beginning of a walk. `throughput` is the path's, relative to its largest channel: the weights go on from it, as
/// the paper's do, so that no walk follows a channel that the path has already lost.
struct WalkStart {
  Vec3f direction;  // unit
  Vec3f inward;     // unit, normal of the entry surface: the axis of guiding
  ChannelValues throughput{1, 1, 1};
  /// Unit: walks are guided this way alone. Zero: to the surface that they entered through and to the opposite one.
  Vec3f to_light{0, 0, 0};
  HalfSpaceTwin* twin = nullptr;  // follows the walk; null: none
  double depth = 0;               // below the surface, against `inward`
};

template <class Hit>
struct WalkLoopExit {
  Hit hit;
  Vec3f direction;  // of the last segment
  ChannelValues throughput{};
  uint32_t events = 0;  // scattering events; a sphere step counts as one
};

/// A tracer that knows a lower bound of the distance to the nearest surface, in world units. Where the bound is less
/// than the argument, any lesser one will do. Sphere steps need such a tracer.
template <class Tracer>
concept BoundsDistance = requires(const Tracer& tracer) {
  tracer.distance_bound(1.0);
};

/// A walk from where `tracer` stands until the surface is met. A tracer keeps the position and has:
///   Hit                                      its record of a surface point
///   bool intersect(dir, tmax, Hit*)          nearest surface within tmax, both in world units
///   double exit_distance(hit)                distance through the medium to it
///   bool advance(dir, t)                     moves; false if that left the body without crossing its surface
/// Segment is ChromaticSegment or GuidedSegment; tests put wrong ones here to see that they notice.
/// Phase samples its phase function perfectly, so that directions weigh one; shortcuts are for isotropic scattering.
template <WalkShortcuts kShortcuts, class Segment, class Tracer, class Phase = IsotropicPhase>
class WalkLoop {
 public:
  static_assert(std::is_same_v<Phase, IsotropicPhase> || !(kShortcuts.guiding || kShortcuts.sphere_steps));
  using Exit = WalkLoopExit<typename Tracer::Hit>;

  WalkLoop(Tracer& tracer, const WalkStart& start, const WalkMedium& medium, const WalkSettings& settings,
           SubsurfaceNumbers& numbers, RenderCounters& counters)
      : tracer_(tracer),
        settings_(settings),
        numbers_(numbers),
        counters_(counters),
        medium_(medium),
        twin_(start.twin),
        guide_(start.to_light == Vec3f(0, 0, 0) ? start.inward : -start.to_light),
        phase_(medium.medium.g),
        direction_(start.direction),
        throughput_(start.throughput) {
    for (size_t c = 0; c < 3; ++c)
      if (!medium.medium.active[c]) throughput_[c] = 0;
    entering_ = sum_of(throughput_);
    thickness_known_ = start.to_light != Vec3f(0, 0, 0);
    if constexpr (kShortcuts.guiding) guide_.advance(start.inward, start.depth);
  }

  std::optional<Exit> run() {
    ++counters_.walks;
    if (!(max_value(throughput_) > 0)) return std::nullopt;
    while (events_ < settings_.safety_cap) {
      next_look_ = std::min(events_ + kEventsPerLook, settings_.safety_cap);
      while (events_ < next_look_) {
        const auto exit = step();
        if (exit) return exit;
        if (ended_) return std::nullopt;
      }
      settings_.cancel.check();
    }
    ++counters_.walk_safety_cap;
    if (twin_) twin_->part(throughput_);
    return std::nullopt;
  }

 private:
  struct Nothing {
    template <class... Anything>
    explicit Nothing(const Anything&...) {}
  };
  using Guide = std::conditional_t<kShortcuts.guiding, WalkGuide, Nothing>;

  /// One segment, and the scattering event at its end.
  std::optional<Exit> step() {
    // Sample a direction and a distance.
    Segment segment = make_segment();
    const float t = sample(segment);
    ++counters_.walk_rays;

    // Leave where the segment meets the end of the medium.
    typename Tracer::Hit hit{};
    const bool meets_surface = tracer_.intersect(direction_, t, &hit);
    if (twin_) twin_->follow(segment, direction_, t, meets_surface);
    if constexpr (MeetsLights<Tracer>)
      tracer_.meet_lights(direction_, t, meets_surface ? &hit : nullptr, events_,
                          [&](double passed) { return segment.exit_throughput(passed); });
    if (meets_surface) {
      throughput_ = segment.exit_throughput(tracer_.exit_distance(hit));
      note_weight();
      ++counters_.walk_exits;
      return Exit{hit, direction_, throughput_, events_};
    }

    // Move to the event; through an open mesh, or without extinction, the walk is lost.
    if (!(t < std::numeric_limits<float>::infinity()) || !move(direction_, t)) {
      lose(t < std::numeric_limits<float>::infinity() ? segment.scatter_throughput(t)
                                                      : segment.exit_throughput(std::numeric_limits<float>::max()));
      return std::nullopt;
    }

    // Scatter, and end by roulette.
    ++counters_.walk_events;
    ++events_;
    throughput_ = segment.scatter_throughput(t);
    note_weight();
    if (!survives_roulette()) return std::nullopt;

    // Cross the interior, and learn where the opposite side is.
    if constexpr (kShortcuts.sphere_steps) take_sphere_steps();
    if constexpr (kShortcuts.guiding) measure_thickness();
    return std::nullopt;
  }

  /// Counts a walk that left through an open mesh, or that never ends without extinction, and its throughput.
  void lose(const ChannelValues& lost) {
    ended_ = true;
    if (twin_) twin_->part(lost);
    ++counters_.walk_lost;
    counters_.walk_lost_energy += sum_of(lost) / entering_;
  }

  Segment make_segment() const {
    if constexpr (kShortcuts.guiding)
      return Segment(GuidedState{medium_, guide_}, throughput_);
    else
      return Segment(medium_, throughput_);
  }

  float sample(Segment& segment) {
    if constexpr (kShortcuts.guiding) {
      return segment.sample(events_ == 0, &direction_, numbers_.of_event(events_));
    } else {
      const auto u = numbers_.of_event(events_);
      if (events_ > 0) direction_ = phase_.sample(direction_, {u[0], u[1]});
      return segment.sample_distance({u[2], u[3]});
    }
  }

  bool leap(const Vec3f& direction, double radius) {
    if (twin_) twin_->jump(direction, static_cast<float>(radius));  // as far as the tracer will
    return move(direction, radius);
  }

  bool move(const Vec3f& direction, double t) {
    if constexpr (kShortcuts.guiding) guide_.advance(direction, t);
    return tracer_.advance(direction, static_cast<float>(t));
  }

  void note_weight() {
    DCHECK(std::isfinite(sum_of(throughput_)));
    counters_.max_walk_weight = std::max(counters_.max_walk_weight, max_value(throughput_));
  }

  /// Roulette on the largest channel, once it is small: unbiased. Where alpha < 1 it ends the walk in the end.
  bool survives_roulette() {
    const double largest = max_value(throughput_);
    if (largest >= kWalkRouletteBelow) return true;
    const double q = largest / kLiftedTo;
    if (!survives(q, numbers_.rng())) {
      ++counters_.walk_roulette_ends;
      ended_ = true;
      if (twin_) twin_->end();
      return false;
    }
    for (double& channel : throughput_) channel /= q;
    return true;
  }

  void take_sphere_steps() {
    while (events_ < next_look_) {
      double mfp = 0;
      for (size_t c = 0; c < 3; ++c)
        if (throughput_[c] > 0) mfp = std::max(mfp, 1 / medium_.sigma_t[c]);
      // A radius below one mean free path gains less than an ordinary event.
      const double bound = tracer_.distance_bound((kSphereMargin + 1) * mfp), radius = bound - kSphereMargin * mfp;
      if (!(radius > mfp)) return;
      if (twin_ && !twin_->has_room(bound)) twin_->part(throughput_);
      if (!jump(radius)) return lose(throughput_);
      ++counters_.walk_sphere_steps;
      ++events_;
      note_weight();
      if (!survives_roulette()) return;
    }
  }

  /// False: the jump left the body through a hole.
  bool jump(double radius) {
    const auto u = numbers_.of_event(events_);
    if constexpr (kShortcuts.guiding) {
      return leap(guided_jump({medium_, guide_}, radius, &throughput_, u), radius);
    } else {
      const Vec3f direction = phase_.sample(direction_, {u[0], u[1]});
      for (size_t c = 0; c < 3; ++c) throughput_[c] *= x_over_sinh(medium_.modes.kappa[c] * radius);
      return leap(direction, radius);
    }
  }

  /// Once per walk, and only when it has become deep enough for the opposite side to matter: along the inward normal.
  void measure_thickness() {
    if (thickness_known_ || ended_) return;
    double mfp = 0, reach = 0;
    for (size_t c = 0; c < 3; ++c) {
      if (!(throughput_[c] > 0)) continue;
      mfp = std::max(mfp, 1 / medium_.sigma_t[c]);
      // Beyond, the share of the opposite side is below exp(-8).
      if (medium_.modes.guided[c]) reach = std::max(reach, 8 / medium_.modes.kappa[c]);
    }
    if (!(guide_.depth() > mfp)) return;
    thickness_known_ = true;
    typename Tracer::Hit hit{};
    ++counters_.walk_rays;
    if (tracer_.intersect(-guide_.outward().n, static_cast<float>(reach), &hit))
      guide_.set_thickness(guide_.depth() + tracer_.exit_distance(hit));
  }

  Tracer& tracer_;
  const WalkSettings& settings_;
  SubsurfaceNumbers& numbers_;
  RenderCounters& counters_;
  const WalkMedium& medium_;
  HalfSpaceTwin* const twin_;
  Guide guide_;
  const Phase phase_;
  Vec3f direction_;
  ChannelValues throughput_;
  double entering_ = 0;  // sum of the throughput at the start
  uint32_t events_ = 0, next_look_ = 0;
  bool ended_ = false, thickness_known_ = false;
};

/// The plain walk: no shortcut whatever the settings say. The phase function is chosen once per walk, so that isotropic
/// media do not pay for others.
template <class Segment = ChromaticSegment, class Tracer>
std::optional<WalkLoopExit<typename Tracer::Hit>> run_plain_walk(Tracer& tracer, const WalkStart& start,
                                                                 const WalkMedium& medium, const WalkSettings& settings,
                                                                 SubsurfaceNumbers& numbers, RenderCounters& counters) {
  constexpr WalkShortcuts kNone{};
  if (medium.medium.g == 0)
    return WalkLoop<kNone, Segment, Tracer>(tracer, start, medium, settings, numbers, counters).run();
  return WalkLoop<kNone, Segment, Tracer, HenyeyGreensteinPhase>(tracer, start, medium, settings, numbers, counters)
      .run();
}

/// The walk with the shortcuts that pay; sphere steps only where the tracer can bound distances.
template <class Tracer>
std::optional<WalkLoopExit<typename Tracer::Hit>> run_walk(Tracer& tracer, const WalkStart& start,
                                                           const WalkMedium& medium, const WalkSettings& settings,
                                                           SubsurfaceNumbers& numbers, RenderCounters& counters) {
  const WalkShortcuts use{settings.guiding && medium.worthwhile.guiding,
                          settings.sphere_steps && medium.worthwhile.sphere_steps};
  if constexpr (BoundsDistance<Tracer>) {
    if (use.sphere_steps && tracer.bounds_distance()) {
      if (use.guiding)
        return WalkLoop<WalkShortcuts{true, true}, GuidedSegment, Tracer>(tracer, start, medium, settings, numbers,
                                                                          counters)
            .run();
      return WalkLoop<WalkShortcuts{false, true}, ChromaticSegment, Tracer>(tracer, start, medium, settings, numbers,
                                                                            counters)
          .run();
    }
  }
  if (use.guiding)
    return WalkLoop<WalkShortcuts{true, false}, GuidedSegment, Tracer>(tracer, start, medium, settings, numbers,
                                                                       counters)
        .run();
  return run_plain_walk(tracer, start, medium, settings, numbers, counters);
}

}  // namespace alabaster
