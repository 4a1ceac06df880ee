// A path as text, vertex by vertex: for those who ask why a sample has its color, or why it has none. An integrator
// that was selected with layers writes it where PathContext::record is given; the path is the same with and without.
#pragma once

#include <optional>
#include <string>

#include "core/color/rgb.h"
#include "core/diagnostics/counters.h"
#include "core/geometry/surface_hit.h"
#include "core/math/ray.h"
#include "core/subsurface/walk_record.h"

namespace alabaster {

struct Instance;
struct LightWeight;

/// Positions and directions are written in the world, lengths in its units, light as radiance.
class PathRecord {
 public:
  /// `origin`: the world position of render space's origin.
  explicit PathRecord(const Vec3d& origin) : origin_(origin) {}
  /// Writes no text, and finds only cause().
  PathRecord() : is_written_(false) {}

  void follow(const Ray& ray, const Rgb& throughput, float pdf);
  /// Emission that the ray met, already weighed against light sampling. Black is not written.
  void meet_light(const Rgb& light);
  void meet_surface(const Instance& instance, const TriangleHit& triangle, const SurfaceHit& hit);
  /// A light was sampled in direction `wi`, and the lobes answered. light_arrives() follows unless it is shadowed.
  void sample_light(const Vec3f& wi, const Rgb& f_cos, float pdf);
  void light_arrives(const Rgb& light, const LightWeight& weight);
  void sample_lobe(const char* lobe, const Rgb& f_cos, float pdf);
  /// For RandomWalk, which writes its steps there; leave_body() writes them down.
  WalkRecord* walk() { return is_written_ ? &walk_ : nullptr; }
  void leave_body(const Instance& instance, const TriangleHit& triangle, const SurfaceHit& hit, const Rgb& throughput);
  /// Light that a half-space would send on at the vertex was added; the twin of a walk takes it away again, on average.
  void add_flat_light(const Rgb& light);
  void twin_leaves(const Rgb& light);
  /// The path splits: all until the next call belongs to path `index` of `count`, whose light counts 1 / count.
  void branch(uint32_t index, uint32_t count);
  void end(const char* reason);

  const std::string& text() const { return text_; }
  /// The first number of the path that was not finite.
  NonfiniteCause cause() const { return cause_.value_or(NonfiniteCause::other); }

 private:
  void check(const Rgb& value, NonfiniteCause cause) {
    if (!cause_ && !is_finite(value)) cause_ = cause;
  }
  void line(int indent, const std::string& text);
  void finish_light();
  std::string position(const Vec3f& p) const;
  std::string surface(const Instance& instance, const TriangleHit& triangle, const SurfaceHit& hit) const;
  void write_walk();

  Vec3d origin_{0, 0, 0};
  bool is_written_ = true;
  std::optional<NonfiniteCause> cause_;
  std::string text_;
  WalkRecord walk_;
  int vertices_ = 0, vertices_before_split_ = 0;
  bool light_is_open_ = false;  // a sampled light may still arrive
};

}  // namespace alabaster
