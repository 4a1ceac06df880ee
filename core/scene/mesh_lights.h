// Instances that emit, as lights.
#pragma once

#include <map>
#include <tuple>

#include "core/scene/scene.h"

namespace alabaster {

/// True if some triangle has a material that emits.
bool emits(const Instance& instance);

/// The emissive triangles of an instance that emits and stands still, in render space. `index`: of the instance.
/// `budget` counts the light and may be null. Throws BuildCancelled and MemoryRefused.
MeshLight make_mesh_light(const Instance& instance, uint32_t index, const std::shared_ptr<MemoryBudget>& budget,
                          const CancelToken& cancel);

/// The emissive meshes of a snapshot, which must outlive it.
class KnownMeshLights {
 public:
  /// `snapshot` may be null.
  explicit KnownMeshLights(const SceneSnapshot* snapshot);
  /// One that emits alike at the same place: its light is that of the instance, but for the index. Null: there is none.
  const MeshLight* find(const Instance& instance) const;

 private:
  const SceneSnapshot* snapshot_;
  using Key = std::tuple<const MeshPrototype*, float, float, float>;
  static Key key(const Instance& instance) {
    const Vec3f& place = instance.object_to_world.t;
    return {instance.prototype, place.x, place.y, place.z};
  }
  std::multimap<Key, const MeshLight*> lights_;
};

}  // namespace alabaster
