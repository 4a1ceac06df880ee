// What is rendered. SceneDescription is what a delegate writes; SceneSnapshot is compiled from it, immutable and
// numbered: all that render threads ever see. Parts are shared by pointer, so a new snapshot costs what changed.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "core/geometry/distance_grid.h"
#include "core/geometry/embree_scene.h"
#include "core/geometry/mesh.h"
#include "core/geometry/shells.h"
#include "core/light/light_set.h"
#include "core/material/disney_material.h"
#include "core/subsurface/random_walk.h"
#include "core/subsurface/walk_set.h"

namespace alabaster {

/// A refined mesh with its own BVH: shared by all its instances, built once per edit of the mesh.
struct MeshPrototype {
  Mesh mesh;
  std::shared_ptr<const ObjectScene> object;

  /// Found when first asked for, which is when a material that scatters meets the mesh. Any thread.
  const MeshShells& shells() const;
  /// Likewise, where sphere steps pay; null if the mesh has none (build_distance_grid).
  const DistanceGrid* distances() const { return distances_.get(mesh); }

 private:
  mutable LazyDistanceGrid distances_;
  mutable std::once_flag shells_once_;
  mutable MeshShells shells_;
};

struct InstanceDescription {
  std::shared_ptr<const MeshPrototype> prototype;
  Matrix4d object_to_world;
  std::vector<std::shared_ptr<const DisneyMaterial>> materials;  // by the mesh's material slot; at least one
  int32_t prim_id = 0;
  int32_t instance_id = 0;  // flattened, innermost fastest; 0 when not instanced
  std::string name;         // prim path, for reports
  /// Instances that scatter and name the same set do so as one body; empty: each for itself.
  std::string subsurface_set = {};
};

struct SceneDescription {
  std::vector<InstanceDescription> instances;
  std::vector<LightDescription> lights;
};

/// What the inner loop may meet, and therefore has to be able to do.
struct SceneFeatures {
  bool subsurface = false;
  bool emissive_meshes = false;
  bool textures = false;
  bool smooth_normals = false;
  bool visible_background = false;  // a dome that the camera sees: the background is opaque
};

/// Object space to RENDER space and what is needed at a hit.
struct Instance {
  const MeshPrototype* prototype = nullptr;
  Affine object_to_world;
  Affine world_to_object;
  std::vector<const DisneyMaterial*> materials;  // by slot, at least one
  int32_t prim_id = 0, instance_id = 0;
  const MeshShells* shells = nullptr;  // null: no material of it scatters
  WalkSpace walk;                      // where walks that enter here go on
  uint32_t member = 0;                 // of walk.set

  /// The material of a triangle; slots beyond the list use the first.
  const DisneyMaterial& material(uint32_t triangle) const {
    const auto& slots = prototype->mesh.triangle_material;
    const auto slot = slots.empty() ? size_t(0) : static_cast<size_t>(slots[triangle]);
    return *materials[slot < materials.size() ? slot : 0];
  }
};

/// Immutable. Render space = world - origin: the origin is the centre of the scene's bounds, so that precision does not
/// depend on where in the world a scene stands.
struct SceneSnapshot {
  uint64_t number = 0;
  Vec3d origin{0, 0, 0};
  float radius = 0;  // of a sphere about the render-space origin that holds all geometry
  SceneFeatures features;
  std::vector<Instance> instances;
  std::shared_ptr<const InstancedScene> top;
  LightSet lights;
  size_t memory_bytes = 0;

  std::vector<std::shared_ptr<const WalkSet>> walk_sets;         // keep-alive
  std::vector<std::shared_ptr<const MeshPrototype>> prototypes;  // keep-alive
  std::vector<std::shared_ptr<const DisneyMaterial>> materials;  // keep-alive
};

std::shared_ptr<const SceneSnapshot> compile_snapshot(const SceneDescription& description, uint64_t number,
                                                      const std::shared_ptr<TraceDevice>& device,
                                                      const DiagnosticSink& sink);

}  // namespace alabaster
