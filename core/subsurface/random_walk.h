// Path-traced subsurface scattering: Chiang, Kutz, Burley 2016, sections 2 and 3.
//
// The walk enters through a cosine lobe, scatters isotropically or as Henyey and Greenstein say, and leaves where a
// segment meets the surface.
// Distances are sampled for one channel, chosen with probability proportional to the throughput (times alpha in the
// paper's own weights), and the estimators of the channels are combined by the balance heuristic (one-sample MIS).
// Termination is by roulette on the largest channel of the throughput: unbiased, no bounce cap. A safety cap of 1e6
// events guards against broken geometry and is counted. The shortcuts, guiding and sphere steps, are no part of the
// paper: random_walk_loop.h.
#pragma once

#include <optional>

#include "core/diagnostics/counters.h"
#include "core/geometry/distance_grid.h"
#include "core/geometry/embree_scene.h"
#include "core/math/bounds.h"
#include "core/math/frame.h"
#include "core/sampling/pixel_sampler.h"
#include "core/subsurface/medium.h"

namespace alabaster {

enum class WalkWeights {
  throughput,               // w ~ T: bounded throughput in every geometry; the default
  throughput_times_albedo,  // w ~ T alpha: the paper's
};

struct WalkSettings {
  AlbedoInversion inversion = AlbedoInversion::exact;
  WalkWeights weights = WalkWeights::throughput;
  bool guiding = true;       // Dwivedi guiding, where it pays; affects noise only
  bool sphere_steps = true;  // jumps through the interior, where they pay; their bias is below 3e-4 of the albedo
  uint32_t safety_cap = 1000000;
};

struct WalkSet;

/// The space a walk lives in: positions in the object space of one mesh, directions and distances of the world, so that
/// scatter distances stay world distances under any affine instance transform. Or positions in the space of a set.
struct WalkSpace {
  const ObjectScene* object = nullptr;
  Affine world_to_object;  // only its linear part is used
  /// In the object's space: a walk that scatters outside them has left through an open mesh and ends there.
  /// Empty: not known; such a walk then goes on until it is absorbed.
  Bounds bounds;
  /// Of the object, for sphere steps; null: none are taken.
  const DistanceGrid* distances = nullptr;
  float distance_scale = 1;      // world distance >= this times object distance
  bool room_to_guide = true;     // false: too few mean free paths across for guiding to pay
  const WalkSet* set = nullptr;  // not null: this is the body, and nothing above is used
};

struct WalkEntry {
  Vec3f p;             // in the walk's space, already offset to the inner side of the surface (offset_point)
  Vec3f ng_inward;     // unit, world: geometric normal pointing into the medium
  Frame frame_inward;  // world: n is the shading normal pointing into the medium; the entry lobe is about it
  Rgb throughput{
      1.0f};  // of the path so far, relative to its largest channel: weighs the channels from the first segment
  /// Unit, world: the path came to p through the medium already, and goes on this way. Else the entry lobe is sampled.
  std::optional<Vec3f> direction = {};
  /// World distance along ng_inward from the surface to p: medium that the walk has to cross, though nothing was traced
  /// in it. Small against the mean free path: see is_resolved().
  float depth = 0;
  bool from_behind = false;  // into a set, through the inner side of an open shell: the medium is on its outer side
};

struct WalkExit {
  TriangleHit hit;       // where it left; ids are of the ObjectScene, or of the set's members
  Vec3f direction;       // unit, world: of the last segment (towards the surface, from inside)
  Rgb throughput{0.0f};  // WalkEntry's times the walk's
  /// Scattering events; 0: crossed without scattering. Sorts the light into unscattered, single (1) and multiple
  /// (>= 2), so a step that stands for many events must count at least two.
  uint32_t events = 0;
};

/// Whether walks can tell `scatter_distance` from zero where they begin `depth` below the surface. What scatters
/// nearer than that does so at that depth: of the mean free paths' starts a share depth / mfp is off by as much, which
/// is 2e-4 of the light at this limit.
inline bool is_resolved(float scatter_distance, float depth) {
  constexpr float kDepths = 64;
  return scatter_distance > kDepths * depth;
}

/// Direction in which a walk enters, unit, world. The lobe is the cosine hemisphere about the shading normal.
/// Directions of it that a tilted shading normal sends out of the body are mirrored in the surface: how much light
/// enters is the caller's (1-.5F_V), the lobe only says where it goes, so its mass stays one. Dropping them instead
/// would darken smooth-shaded silhouettes and break the white furnace.
Vec3f sample_walk_entry(const WalkEntry& entry, const Vec2f& u);

/// Runs one walk. `u_entry` samples the entry direction; everything else comes from `rng`. Empty: absorbed, ended by
/// roulette, or lost through an open mesh (counted in `counters`).
std::optional<WalkExit> random_walk(const WalkSpace& space, const WalkEntry& entry, const Medium& medium,
                                    const WalkSettings& settings, const Vec2f& u_entry, Rng& rng,
                                    RenderCounters& counters);

}  // namespace alabaster
