// Motion over the shutter. A thing that moves has a pose at each of several times, evenly spaced from the shutter's
// opening (time 0) to its close (time 1), and moves linearly in between: Embree traces the same.
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <vector>

#include "core/math/transform.h"

namespace alabaster {

/// Values at increasing times, in frames, relative to the frame that is drawn. Before the first and after the last the
/// value stands still.
template <class T>
struct TimeSamples {
  std::vector<double> times;
  std::vector<T> values;
  bool moves() const { return values.size() > 1; }
  bool operator==(const TimeSamples&) const = default;
};

/// In frames, relative to the frame that is drawn; open <= close.
struct Shutter {
  double open = 0, close = 0;
  double length() const { return close - open; }
  double time(double share) const { return open + length() * share; }
  bool operator==(const Shutter&) const = default;
};

/// From the first that opens to the last that closes.
inline Shutter united(const Shutter& a, const Shutter& b) {
  return {std::min(a.open, b.open), std::max(a.close, b.close)};
}

/// Between poses `first` and first + 1 of `count`, the share `fraction` of the way. As Embree finds it.
struct PoseTime {
  size_t first;
  float fraction;

  /// `time` in 0..1; count >= 2.
  PoseTime(float time, size_t count) {
    const float scaled = time * static_cast<float>(count - 1);
    first = std::min(static_cast<size_t>(scaled), count - 2);
    fraction = scaled - static_cast<float>(first);
  }
  template <class T>
  T between(const T& a, const T& b) const {
    return a * (1 - fraction) + b * fraction;
  }
};

/// The map of even poses at `time`; at least two.
Affine posed(const std::vector<Affine>& poses, float time);
/// The inverse of an invertible map, by way of double.
Affine inverse(const Affine& map);

/// The matrix at a time; there must be a sample. Translation and stretch are interpolated linearly, rotation on the
/// sphere (Shoemake and Duff 1992, "Matrix Animation and Polar Decomposition"): a body which turns keeps its size, and
/// one which is sheared needs no case of its own. Rotations take the shorter way, so half a turn or more between
/// samples is not seen. Matrices that cannot be decomposed (singular, or one of the two mirrored) are interpolated
/// entry by entry.
Matrix4d interpolate(const TimeSamples<Matrix4d>& samples, double time);

/// The samples' times, and as many between as a turn needs: no step turns by more than 3 degrees. At these a motion is
/// joined with another one, as what stands away from its axis would else cut the corners.
std::vector<double> times_of_turns(const TimeSamples<Matrix4d>& samples);

/// How many even poses over the shutter show all samples: each sample lies on a pose, up to `most` poses, beyond which
/// corners of the motion are rounded. 1 if nothing changes.
size_t even_pose_count(const std::vector<double>& times, const Shutter& shutter, size_t most);

/// Embree's limit.
inline constexpr size_t kMostPoses = 129;

/// Even poses over the shutter; one if the samples stand still in it. Between poses maps are interpolated entry by
/// entry, which shrinks what turns: no step turns by more than 3 degrees (a radius shrinks by less than 4e-4), unless
/// the whole needs more than kMostPoses.
std::vector<Matrix4d> even_poses(const TimeSamples<Matrix4d>& samples, const Shutter& shutter);

/// A lower bound of least_stretch() over the whole motion from one map to another, entry by entry; 0 if the motion goes
/// through a singular map, or nearly so.
float least_stretch_between(const Affine& a, const Affine& b);
/// The same over all poses.
float least_stretch_over(const std::vector<Affine>& poses);

}  // namespace alabaster
