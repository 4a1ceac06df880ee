// Bodies whose walks have a closed-form or quadrature answer, traced in double precision by the renderer's own loop.
#pragma once

#include "core/subsurface/random_walk_loop.h"

namespace alabaster::testing {

struct BodyHit {
  double t = 0;
  int side = 0;  // slab and edge: 0 the side entered through, 1 the other
};

inline Vec3d to_double(const Vec3f& v) {
  return {v.x, v.y, v.z};
}

/// 0 <= z <= thickness, entered at the origin; infinite thickness: a half-space.
class SlabTracer {
 public:
  using Hit = BodyHit;

  explicit SlabTracer(double thickness = std::numeric_limits<double>::infinity()) : thickness_(thickness) {}

  bool intersect(const Vec3f& direction, float tmax, Hit* hit) const {
    if (direction.z < 0) *hit = {p_.z / -static_cast<double>(direction.z), 0};
    if (direction.z > 0) *hit = {(thickness_ - p_.z) / direction.z, 1};
    return direction.z != 0 && hit->t <= tmax;
  }
  double exit_distance(const Hit& hit) const { return hit.t; }
  static bool bounds_distance() { return true; }
  double distance_bound(double) const { return std::min(p_.z, thickness_ - p_.z); }
  bool advance(const Vec3f& direction, float t) {
    p_ += to_double(direction) * t;
    return true;
  }
  const Vec3d& position() const { return p_; }

 private:
  double thickness_;
  Vec3d p_{0, 0, 0};
};

/// The quarter space x >= 0, z >= 0, entered through z = 0 at a distance from its edge.
class EdgeTracer {
 public:
  using Hit = BodyHit;

  explicit EdgeTracer(double distance) : p_(distance, 0, 0) {}

  bool intersect(const Vec3f& direction, float tmax, Hit* hit) const {
    hit->t = std::numeric_limits<double>::infinity();
    if (direction.z < 0) *hit = {p_.z / -static_cast<double>(direction.z), 0};
    if (direction.x < 0 && p_.x < hit->t * -static_cast<double>(direction.x))
      *hit = {p_.x / -static_cast<double>(direction.x), 1};
    return hit->t <= tmax;
  }
  double exit_distance(const Hit& hit) const { return hit.t; }
  static bool bounds_distance() { return true; }
  double distance_bound(double) const { return std::min(p_.x, p_.z); }
  bool advance(const Vec3f& direction, float t) {
    p_ += to_double(direction) * t;
    return true;
  }
  const Vec3d& position() const { return p_; }

 private:
  Vec3d p_;
};

/// The ellipsoid x = scale * (unit sphere), entered at scale * pole. A sphere when all scales are equal.
class EllipsoidTracer {
 public:
  using Hit = BodyHit;

  EllipsoidTracer(const Vec3d& scale, const Vec3d& pole) : inverse_scale_(1 / scale.x, 1 / scale.y, 1 / scale.z) {
    p_ = {scale.x * pole.x, scale.y * pole.y, scale.z * pole.z};
  }

  bool intersect(const Vec3f& direction, float tmax, Hit* hit) const {
    const Vec3d d = to_double(direction) * inverse_scale_, p = p_ * inverse_scale_;
    const double a = dot(d, d), b = dot(p, d), c = std::min(dot(p, p) - 1, 0.0);
    const double root = std::sqrt(b * b - a * c);
    hit->t = b > 0 ? -c / (b + root) : (root - b) / a;
    return hit->t <= tmax;
  }
  double exit_distance(const Hit& hit) {
    path_length_ += hit.t;
    return hit.t;
  }
  bool advance(const Vec3f& direction, float t) {
    p_ += to_double(direction) * t;
    path_length_ += t;
    return true;
  }
  double path_length() const { return path_length_; }
  const Vec3d& position() const { return p_; }

 private:
  Vec3d inverse_scale_, p_;
  double path_length_ = 0;
};

/// A sphere entered at its pole z = -radius; by symmetry every entry point is the same.
class SphereTracer : public EllipsoidTracer {
 public:
  explicit SphereTracer(double radius) : EllipsoidTracer({radius, radius, radius}, {0, 0, -1}), radius_(radius) {}
  static bool bounds_distance() { return true; }
  double distance_bound(double) const { return std::max(0.0, radius_ - length(position())); }

 private:
  double radius_;
};

/// A grey medium of extinction 1.
inline Medium unit_medium(double complement) {
  Medium medium;
  for (int c = 0; c < 3; ++c) {
    medium.active[c] = c == 0;
    medium.sigma_t[c] = c == 0 ? 1.0f : 0.0f;
    medium.alpha[c] = c == 0 ? static_cast<float>(1 - complement) : 0.0f;
    medium.one_minus_alpha[c] = c == 0 ? static_cast<float>(complement) : 1.0f;
  }
  return medium;
}

/// Every body is entered along +z.
inline WalkStart start_walk(const SubsurfaceNumbers& numbers) {
  constexpr Vec3f kInward(0, 0, 1);
  const auto& u = numbers.first();
  return {sample_entry_direction(kInward, kInward, {u[0], u[1]}), kInward, {1, 1, 1}};
}

/// One plain walk from the entry's cosine lobe.
template <class Segment = ChromaticSegment, class Tracer>
std::optional<WalkLoopExit<BodyHit>> walk_body(Tracer& tracer, const WalkMedium& medium, const WalkSettings& settings,
                                               Rng& rng, RenderCounters& counters) {
  SubsurfaceNumbers numbers(rng);
  const auto exit = run_plain_walk<Segment>(tracer, start_walk(numbers), medium, settings, numbers, counters);
  rng = numbers.rng();
  return exit;
}

/// The same with the shortcuts that the settings allow and that pay.
template <class Tracer>
std::optional<WalkLoopExit<BodyHit>> walk_body_with_shortcuts(Tracer& tracer, const WalkMedium& medium,
                                                              const WalkSettings& settings, Rng& rng,
                                                              RenderCounters& counters) {
  SubsurfaceNumbers numbers(rng);
  const auto exit = run_walk(tracer, start_walk(numbers), medium, settings, numbers, counters);
  rng = numbers.rng();
  return exit;
}

}  // namespace alabaster::testing
