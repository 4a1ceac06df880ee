// Ray tracing by Embree, which this folder alone includes. Two levels: one bottom-level BVH per mesh (in object space),
// one top level of instances. Rays that Embree would abort the host on (not finite, beyond 1e17) never reach it: they
// miss.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <memory_resource>
#include <vector>

#include "core/geometry/instance_cell.h"
#include "core/geometry/mesh.h"
#include "core/math/motion.h"
#include "core/math/ray.h"

namespace alabaster {

/// Owns the Embree device. One per delegate; outlives what is built with it (held by shared_ptr inside).
class TraceDevice;
/// Null if Embree has none to give (reported). All memory that Embree takes for it is counted in the budget, which may
/// be null. Builds that would exceed it throw MemoryRefused, and those for which memory runs out std::bad_alloc.
std::shared_ptr<TraceDevice> make_trace_device(const DiagnosticSink& sink,
                                               std::shared_ptr<MemoryBudget> memory = nullptr);
/// The budget of the device; may be null.
const std::shared_ptr<MemoryBudget>& memory_of(const TraceDevice& device);

struct TriangleHit {
  float t = 0;         // in units of the ray's |dir|
  float u = 0, v = 0;  // barycentric: p = (1-u-v) p0 + u p1 + v p2
  uint32_t triangle = 0;
  uint32_t instance = 0;  // InstancedScene only: index into the instances it was built from
  float time = 0;         // of the ray: where the triangle was then
  Vec3f normal{0, 0,
               0};  // of the triangle in its own space then, of any length; its winding is seen from where it points
};

/// BVH of one mesh in object space, with its motion if it deforms. Immutable; traced from any thread.
class ObjectScene {
 public:
  virtual ~ObjectScene() = default;
  /// Nearest hit with t in [0, ray.tmax]; false if none. Both sides of a triangle are hit.
  virtual bool intersect(const Ray& ray, TriangleHit* hit) const = 0;
  /// Every hit with t in [0, ray.tmax], by t, then by triangle, whatever the hierarchy looks like: replaces what `hits`
  /// held.
  virtual void intersect_all(const Ray& ray, std::pmr::vector<TriangleHit>* hits) const = 0;
  virtual size_t memory_bytes() const = 0;
};
/// `cancelled` (may be empty) is asked while building, from any of its threads and not always at a time; when it
/// returns true the build stops and null is returned. The mesh is copied. Builds with the threads of the caller's task
/// arena. Null also when Embree refuses for another reason than memory (reported). Where memory runs out, throws
/// MemoryRefused, by the budget of the device, or std::bad_alloc, unreported. A mesh without triangles is never hit.
std::shared_ptr<const ObjectScene> build_object_scene(const std::shared_ptr<TraceDevice>& device, const Mesh& mesh,
                                                      const std::function<bool()>& cancelled);

struct InstancePlacement {
  std::shared_ptr<const ObjectScene> object;
  Affine object_to_world;
  std::vector<Affine> poses = {};  // of an instance that moves: even ones over the shutter, 2 to kMostPoses
};

/// Asked of each hit that a ray meets on its way, in no order, on the ray's thread.
class HitFilter {
 public:
  virtual ~HitFilter() = default;
  /// False: the ray passes as if there were nothing.
  virtual bool stops(const TriangleHit& hit) const noexcept = 0;
};

/// Top level over instances: those that stand alone (flattened: one level of instancing), and arrays of cells.
/// Immutable; traced from any thread.
class InstancedScene {
 public:
  virtual ~InstancedScene() = default;
  /// `filter` null: every hit stops the ray.
  virtual bool intersect(const Ray& ray, TriangleHit* hit, const HitFilter* filter = nullptr) const = 0;
  virtual bool occluded(const Ray& ray, const HitFilter* filter = nullptr) const = 0;
  virtual size_t memory_bytes() const = 0;
};
/// A placement without an object, and one that is not traceable, is never hit; the others keep their indices. Rays that
/// a placement would carry beyond what Embree takes miss everything: leave out what is not traceable from afar.
/// Null and exceptions as those of build_object_scene(). The instances of `arrays` have the indices that follow.
std::shared_ptr<const InstancedScene> build_instanced_scene(const std::shared_ptr<TraceDevice>& device,
                                                            const std::vector<InstancePlacement>& instances,
                                                            const std::function<bool()>& cancelled = {},
                                                            const std::vector<InstanceCells>& arrays = {});

/// Rays and transforms that Embree is given stay below this; it aborts from 1.8e18 on.
inline constexpr float kTraceLimit = 1e17f;

/// True if Embree may be given this ray.
inline bool is_traceable(const Ray& ray) {
  return max_abs_component(ray.org) < kTraceLimit && max_abs_component(ray.dir) < kTraceLimit && ray.tmax >= 0 &&
         is_finite(ray.org) && is_finite(ray.dir);
}

/// True if every ray of unit direction that starts within `distance` of the origin may be traced through this
/// placement: Embree inverts it in float, and aborts as well when the ray is too large in object space. False for what
/// is flat or huge or tiny beyond floats.
bool is_traceable(const Affine& object_to_world, float distance);
/// The same through all poses of an instance that moves, and in between. False also where it turns inside out.
bool is_traceable(const std::vector<Affine>& poses, float distance);

}  // namespace alabaster
