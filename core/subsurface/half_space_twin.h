// A walk's twin in the half-space that its body looks like from the entry: a control variate (random_walk.md). It takes
// the walk's steps for as long as they are possible in the half-space as well. Where the two part, the rest of the
// twin's way is not walked: its expectation is known.
#pragma once

#include <limits>

#include "core/subsurface/half_space.h"
#include "core/subsurface/walk_medium.h"

namespace alabaster {

/// For isotropic scattering. The walk's steps may follow the body in any way, for their densities are in the
/// throughput.
class HalfSpaceTwin {
 public:
  /// `outward`: unit normal of the plane through the point where the walk enters.
  HalfSpaceTwin(const Vec3f& outward, const WalkMedium& medium) : outward_(outward), medium_(medium) {}

  /// Throughput with which the twin leaves the half-space, on average over what it has not walked: over all walks the
  /// albedo of the half-space times the throughput at the start.
  const ChannelValues& throughput() const { return throughput_; }

  /// The walk drew distance t along `direction`, and meets the surface of the body on the way or not.
  template <class Segment>
  void follow(const Segment& segment, const Vec3f& direction, float t, bool meets_surface) {
    if (!joined_) return;
    const double rise = dot(direction, outward_);
    if (rise > 0 && rise * t >= depth_) {
      joined_ = false;
      throughput_ = segment.exit_throughput(depth_ / rise);
    } else if (!(t < std::numeric_limits<float>::infinity())) {
      joined_ = false;
    } else {
      depth_ -= rise * t;
      if (meets_surface) part(segment.scatter_throughput(t));
    }
  }

  /// False: no sphere step of the walk fits into the half-space that keeps away from the surface by `bound`.
  bool has_room(double bound) const { return depth_ >= bound; }
  void jump(const Vec3f& direction, double radius) { depth_ -= static_cast<double>(dot(direction, outward_)) * radius; }

  /// The walk cannot be followed any more, after an event where both had `throughput`.
  void part(const ChannelValues& throughput) {
    if (!joined_) return;
    joined_ = false;
    for (size_t c = 0; c < 3; ++c) {
      if (!(throughput[c] > 0)) continue;
      const double complement = medium_.medium.one_minus_alpha[static_cast<int>(c)];
      throughput_[c] = throughput[c] * escape_probability(complement, medium_.x_of(c), medium_.sigma_t[c] * depth_);
    }
  }
  /// Roulette ended both.
  void end() { joined_ = false; }

 private:
  const Vec3f outward_;
  const WalkMedium& medium_;
  double depth_ = 0;
  bool joined_ = true;
  ChannelValues throughput_{};
};

}  // namespace alabaster
