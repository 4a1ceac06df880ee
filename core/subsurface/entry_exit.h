// Subsurface entries and exits: every carrier of light through a body is asked where light that enters here comes out.
// A carrier (RandomWalk, NormalizedDiffusion) is a small struct of settings with
//
//   std::optional<SubsurfaceExit> carry(const SubsurfaceBody&, const SubsurfaceEntry&, SubsurfaceNumbers&,
//                                       RenderCounters&) const;
//
// A carrier is a pure function of these, callable from any thread.
#pragma once

#include <array>
#include <optional>

#include "core/geometry/surface_hit.h"
#include "core/sampling/pixel_sampler.h"
#include "core/subsurface/walk_medium.h"

namespace alabaster {

/// A point of a body's surface where a path goes below it. World directions and distances, render space.
struct SubsurfaceEntry {
  TriangleHit triangle;                // in the mesh of the member
  uint32_t member = 0;                 // of the body: whose surface it is
  SurfaceHit hit;                      // normals on the side that the path comes from
  Vec3f ns{0, 0, 1};                   // unit, on the same side: the entry lobe is about it
  Rgb throughput{1.0f};                // of the path so far
  const WalkMedium* medium = nullptr;  // of the object that the path enters
  /// The path came to the surface through the medium, from a camera inside or past a surface of the same body: it walks
  /// on along this ray instead of entering.
  std::optional<Ray> within = {};
  float gap = 0;  // the medium before that ray's origin, which the walk has to come through
};

struct SubsurfaceExit {
  TriangleHit hit;       // hit.instance: index into the scene's instances
  Vec3f direction;       // unit, world: of the last segment, from inside towards the surface
  Rgb throughput{0.0f};  // of the path, without the exit lobe
  /// Scattering events: 0 crossed without scattering, 1, or at least 2 for all that is more. Sorts light into the
  /// layers subsurfaceUnscattered, subsurfaceSingle and subsurfaceMultiple.
  uint32_t events = 0;
  bool is_content = false;  // the walk met what stands in the body, and is still in its medium
};

/// The answer of a carrier that does not count events: a profile stands for all of them at once.
inline constexpr uint32_t kManyEvents = 2;

/// Random numbers of one entry: four for each scattering event. Those of the first events, which move the result most,
/// are well distributed over a pixel's samples; all others are independent.
class SubsurfaceNumbers {
 public:
  /// Events with such numbers; more gain little (testenv/benchmark/results/sampling.md).
  static constexpr uint32_t kStratifiedEvents = 4;

  /// All independent.
  explicit SubsurfaceNumbers(const Rng& rng) : rng_(rng), stratified_(0), first_(independent()) {}
  SubsurfaceNumbers(const PixelSampler& sampler, Dimension purpose, uint32_t depth)
      : sampler_(&sampler),
        purpose_(purpose),
        rng_(sampler.stream(purpose, depth)),
        block_(depth * kStratifiedEvents),
        stratified_(kStratifiedEvents),
        first_(sampler.draw(purpose, block_)) {}

  /// The numbers of the entry: a carrier without a walk needs no others. A walk takes its entry direction from two.
  const std::array<float, 4>& first() const { return first_; }
  /// The numbers of the event after `events` others; asked once each.
  std::array<float, 4> of_event(uint32_t events) {
    if (events == 0) return first_;
    return events < stratified_ ? sampler_->draw(purpose_, block_ + events) : independent();
  }
  /// A stream for what needs no stratification.
  Rng& rng() { return rng_; }

 private:
  std::array<float, 4> independent() {
    std::array<float, 4> u;
    for (float& x : u) x = rng_.uniform();
    return u;
  }

  const PixelSampler* sampler_ = nullptr;
  Dimension purpose_ = Dimension::subsurface;
  Rng rng_;
  uint32_t block_ = 0, stratified_;
  std::array<float, 4> first_;
};

}  // namespace alabaster
