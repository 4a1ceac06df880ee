#include "core/math/motion.h"

#include <ImathMatrixAlgo.h>
#include <ImathQuat.h>

#include <algorithm>
#include <cmath>

namespace alabaster {
namespace {

using Matrix3d = Imath::M33d;

Matrix3d linear_part(const Matrix4d& m) {
  return {m[0][0], m[0][1], m[0][2], m[1][0], m[1][1], m[1][2], m[2][0], m[2][1], m[2][2]};
}

bool all_finite(const Matrix3d& m) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (!std::isfinite(m[i][j])) return false;
  return true;
}

// For row vectors: first the symmetric stretch, then the rotation.
struct PolarParts {
  Matrix3d stretch;
  Imath::Quatd rotation;
  bool mirrored;
};

Imath::Quatd to_quaternion(const Matrix3d& r) {
  Matrix4d m;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) m[i][j] = r[i][j];
  return Imath::extractQuat(m).normalized();
}

// By Higham's iteration: the mean of a matrix and its inverse transpose, which converges quadratically near the end.
std::optional<PolarParts> polar_parts(const Matrix4d& matrix) {
  const Matrix3d m = linear_part(matrix);
  const double determinant = m.determinant();
  if (!std::isfinite(determinant) || determinant == 0) return std::nullopt;
  const double scale = std::cbrt(std::abs(determinant));
  Matrix3d r = m * (1 / scale);
  constexpr int kIterations = 64;
  for (int i = 0; i < kIterations; ++i) {
    const Matrix3d next = (r + r.inverse().transposed()) * 0.5;
    if (!all_finite(next)) return std::nullopt;
    const bool done = next.equalWithAbsError(r, 1e-15);
    r = next;
    if (done) break;
  }
  const bool mirrored = determinant < 0;
  if (mirrored) r = r * -1.0;
  return PolarParts{m * r.transposed(), to_quaternion(r), mirrored};
}

Matrix4d linear(const Matrix4d& a, const Matrix4d& b, double f) {
  return a * (1 - f) + b * f;
}

Matrix4d interpolate(const Matrix4d& a, const Matrix4d& b, double f) {
  if (f == 0 || a == b) return a;
  if (f == 1) return b;
  Matrix4d out = linear(a, b, f);
  if (linear_part(a) == linear_part(b)) return out;
  const auto from = polar_parts(a), to = polar_parts(b);
  if (!from || !to || from->mirrored != to->mirrored) return out;
  const Matrix4d rotation = Imath::slerpShortestArc(from->rotation, to->rotation, f).toMatrix44();
  const Matrix3d m = (from->stretch * (1 - f) + to->stretch * f) * linear_part(rotation);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) out[i][j] = m[i][j];
  return out;
}

// The largest angle between neighbours.
double largest_turn(const std::vector<Matrix4d>& poses) {
  double largest = 0;
  std::optional<PolarParts> last;
  for (const Matrix4d& pose : poses) {
    const auto parts = polar_parts(pose);
    if (last && parts) {
      const double cosine = std::min(1.0, std::abs(last->rotation ^ parts->rotation));
      largest = std::max(largest, 2 * std::acos(cosine));
    }
    last = parts;
  }
  return largest;
}

constexpr double kLargestTurn = 3 * kPiDouble / 180;  // between poses

Affine between(const Affine& a, const Affine& b, float f) {
  const auto mix = [f](const Vec3f& p, const Vec3f& q) { return p * (1 - f) + q * f; };
  return {mix(a.x, b.x), mix(a.y, b.y), mix(a.z, b.z), mix(a.t, b.t)};
}

}  // namespace

Affine posed(const std::vector<Affine>& poses, float time) {
  const PoseTime at(time, poses.size());
  return between(poses[at.first], poses[at.first + 1], at.fraction);
}

Affine inverse(const Affine& map) {
  const Vec3d x(map.x), y(map.y), z(map.z);
  const Vec3d c[3] = {cross(y, z), cross(z, x), cross(x, y)};
  const double r = 1 / dot(x, c[0]);
  const auto row = [&](int i) { return Vec3f(Vec3d(c[0][i], c[1][i], c[2][i]) * r); };
  const Vec3d t(map.t);
  return {row(0), row(1), row(2), Vec3f(Vec3d(dot(t, c[0]), dot(t, c[1]), dot(t, c[2])) * -r)};
}

Matrix4d interpolate(const TimeSamples<Matrix4d>& samples, double time) {
  const auto& times = samples.times;
  const auto after = static_cast<size_t>(std::upper_bound(times.begin(), times.end(), time) - times.begin());
  if (after == 0) return samples.values.front();
  if (after == times.size()) return samples.values.back();
  const double from = times[after - 1], to = times[after];
  return interpolate(samples.values[after - 1], samples.values[after], (time - from) / (to - from));
}

std::vector<double> times_of_turns(const TimeSamples<Matrix4d>& samples) {
  std::vector<double> times;
  for (size_t i = 0; i < samples.times.size(); ++i) {
    if (i > 0) {
      const double from = samples.times[i - 1], length = samples.times[i] - from;
      const auto steps =
          static_cast<int>(std::ceil(largest_turn({samples.values[i - 1], samples.values[i]}) / kLargestTurn));
      for (int k = 1; k < steps; ++k) times.push_back(from + length * k / steps);
    }
    times.push_back(samples.times[i]);
  }
  return times;
}

size_t even_pose_count(const std::vector<double>& times, const Shutter& shutter, size_t most) {
  if (!(shutter.length() > 0) || times.size() < 2) return 1;
  if (times.front() >= shutter.close || times.back() <= shutter.open) return 1;
  const auto fits = [&](size_t steps) {
    return std::all_of(times.begin(), times.end(), [&](double t) {
      if (t <= shutter.open || t >= shutter.close) return true;
      const double at = (t - shutter.open) / shutter.length() * static_cast<double>(steps);
      return std::abs(at - std::round(at)) < 1e-3;
    });
  };
  size_t steps = 1;
  while (steps + 1 < most && !fits(steps)) ++steps;
  return steps + 1;
}

std::vector<Matrix4d> even_poses(const TimeSamples<Matrix4d>& samples, const Shutter& shutter) {
  const auto poses = [&](size_t count) {
    std::vector<Matrix4d> out;
    for (size_t i = 0; i < count; ++i) {
      const double share = count > 1 ? static_cast<double>(i) / static_cast<double>(count - 1) : 0;
      out.push_back(interpolate(samples, shutter.time(share)));
    }
    return out;
  };
  constexpr size_t kMostWithoutTurns = 65;
  const size_t count = even_pose_count(samples.times, shutter, kMostWithoutTurns);
  std::vector<Matrix4d> out = poses(count);
  if (std::all_of(out.begin(), out.end(), [&](const Matrix4d& m) { return m == out.front(); })) return {out.front()};
  const double wanted = std::ceil(largest_turn(out) / kLargestTurn);
  const size_t most = (kMostPoses - 1) / (count - 1);
  const size_t finer = wanted > 1 ? std::min(static_cast<size_t>(wanted), most) : 1;
  return finer > 1 ? poses((count - 1) * finer + 1) : out;
}

// A map between two differs from the nearer one by at most half their difference, and singular values differ by no more
// than the maps do (Weyl). Where that bound is too low, those of the halves are better.
float least_stretch_between(const Affine& a, const Affine& b) {
  constexpr int kHalvings = 12;
  const auto bound = [](const auto& self, const Affine& from, const Affine& to, int halvings) -> float {
    const Vec3f d[3] = {to.x - from.x, to.y - from.y, to.z - from.z};
    const float apart = std::sqrt(dot(d[0], d[0]) + dot(d[1], d[1]) + dot(d[2], d[2]));
    const float at_ends = std::min(least_stretch(from), least_stretch(to));
    const float least = at_ends - 0.5f * apart;
    if (least > 0.75f * at_ends) return least;
    if (halvings == 0 || !(at_ends > 0)) return 0;
    const Affine middle = between(from, to, 0.5f);
    return std::min(self(self, from, middle, halvings - 1), self(self, middle, to, halvings - 1));
  };
  return bound(bound, a, b, kHalvings);
}

float least_stretch_over(const std::vector<Affine>& poses) {
  float least = least_stretch(poses.front());
  for (size_t i = 1; i < poses.size(); ++i) least = std::min(least, least_stretch_between(poses[i - 1], poses[i]));
  return least;
}

}  // namespace alabaster
