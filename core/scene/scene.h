// The scene. A delegate writes a SceneDescription; a SceneSnapshot is compiled from it, immutable and numbered, and
// render threads see nothing else. Parts are shared by pointer, so a new snapshot costs what changed.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/geometry/embree_scene.h"
#include "core/geometry/mesh.h"
#include "core/geometry/placement.h"
#include "core/geometry/surface_hit.h"
#include "core/geometry/tangents.h"
#include "core/light/light_set.h"
#include "core/material/disney_material.h"
#include "core/scene/instance_array.h"
#include "core/scene/mesh_options.h"
#include "core/subsurface/mesh_interior.h"

namespace alabaster {

struct SubsurfaceBody;

/// A refined mesh with its own BVH: shared by all its instances, built once per edit of the mesh.
struct MeshPrototype {
  Mesh mesh;
  std::shared_ptr<const ObjectScene> object;

  const MeshShells& shells(const CancelToken& cancel = {}) const { return interior.shells(mesh, *object, cancel); }
  MeshInterior interior = {};     // only light below the surface asks for it
  TangentCache tangents = {};     // only normal maps ask for them
  MemoryReservation memory = {};  // of the mesh
};

/// The points of a mesh that deforms, at the ends of the time that AOV motion shows.
struct MeshEnds {
  std::array<std::vector<Vec3f>, 2> points;
  MemoryReservation memory = {};
};

/// Material slots by triangle; empty: all 0.
using TriangleSlots = std::vector<int32_t>;

/// Equal where all instances have the same.
struct InstanceValuesPtr : std::shared_ptr<const InstanceValues> {
  using std::shared_ptr<const InstanceValues>::shared_ptr;
  bool operator==(const InstanceValuesPtr& other) const {
    return get() == other.get() || (*this && other && get()->are_alike(*other));
  }
};

struct InstanceDescription {
  std::shared_ptr<const MeshPrototype> prototype;
  Matrix4d object_to_world;
  std::vector<Matrix4d> poses = {};  // of an instance that moves: even ones over the shutter, 2 to kMostPoses
  std::vector<std::shared_ptr<const DisneyMaterial>> materials;  // by the mesh's material slot; at least one
  int32_t prim_id = 0;
  int32_t instance_id = 0;  // flattened, innermost fastest; 0 when not instanced
  std::string name;         // prim path, for reports
  /// Instances that scatter and name the same set do so as one body; empty: each for itself.
  std::string subsurface_set = {};
  MeshOptions options = {};
  uint32_t category_set = 0;                        // of SceneDescription
  uint32_t light_group = 0;                         // where it emits: of SceneDescription, from 1 on; 0: of none
  InstanceValuesPtr values = {};                    // by instance_id
  std::shared_ptr<const TriangleSlots> slots = {};  // in the place of the mesh's own; null: those
  std::vector<Matrix4d> ends = {};                  // object_to_world at those of MeshEnds, two; empty: stands still
  std::shared_ptr<const MeshEnds> mesh_ends = {};   // null: does not deform, or nobody asks

  const TriangleSlots& triangle_slots() const { return slots ? *slots : prototype->mesh.triangle_material; }
  bool operator==(const InstanceDescription&) const = default;
};

/// Many instances that are alike but for where they stand. They stand still. Those that emit, deform, scatter in sets
/// or in shells that are open or overlap are compiled one by one; the others cost little to hold and to edit.
struct InstanceArrayDescription {
  InstanceDescription look;  // without a transform and instance_id, which is the number in the array
  std::shared_ptr<const InstancePlaces> places;

  /// Empty: it is not drawn.
  std::optional<InstanceDescription> instance(size_t number) const;
  bool operator==(const InstanceArrayDescription& other) const;
};

/// The material slots whose triangles let light below their surface, in order. A material that no face uses does not
/// count.
std::vector<size_t> scattering_slots(const InstanceDescription& instance);
/// Those whose materials are such, likewise.
std::vector<size_t> used_slots(const InstanceDescription& instance, bool (*is_such)(const DisneyMaterial&));

/// The mattes of a prim (AOVs crypto_object and crypto_asset) whose name or whose instances have others than its own.
struct MatteNames {
  int32_t prim_id = 0;
  std::string object, asset;  // empty: the prim's own
  uint32_t instances = 0;     // each of so many has a matte of its own; 0: all have one
  bool operator==(const MatteNames&) const = default;
};

struct SceneDescription {
  std::vector<InstanceDescription> instances;
  std::vector<LightParameters> lights;
  /// The categories that the instances of each set are in, of those that lights name (1, 2, ...), in order. Empty where
  /// no light names any: then all instances have set 0.
  std::vector<std::vector<uint32_t>> category_sets;
  std::vector<InstanceArrayDescription> arrays;
  std::vector<std::string> light_groups = {};  // names: the first has the number 1
  std::vector<MatteNames> mattes = {};         // a change of names is one of the scene
  bool operator==(const SceneDescription&) const = default;
};

/// The features that the inner loop may meet, and has to be able to handle.
struct SceneFeatures {
  bool subsurface = false;
  bool emissive_meshes = false;
  bool clear_sheets = false;  // some material is a clear thin surface: light may go straight on through it
  bool textures = false;
  bool see_through = false;         // some instance is, and not only where rays begin behind it
  bool motion = false;              // an instance or a light moves, or a shape deforms: rays have a time
  bool visible_background = false;  // a dome that the camera sees: the background is opaque
  bool lobe_scales = false;         // a light has scales for lobes: rays keep the shares of those that they left by
  bool shadow_catchers = false;     // some instance is one: films keep the light there
};

struct InstanceArray;

/// An instance at the ends of the time that AOV motion shows.
struct InstanceEnds {
  std::array<Affine, 2> object_to_world;
  std::shared_ptr<const MeshEnds> mesh;  // null: it does not deform
};

/// A placed mesh, and the materials at a hit. The Placement is that of one that stands still, by itself.
struct Instance : Placement {
  const MeshPrototype* prototype = nullptr;
  std::vector<Affine> poses;                     // of one that moves: even ones over the shutter
  std::vector<const DisneyMaterial*> materials;  // by slot, at least one
  const TriangleSlots* slots = nullptr;          // the mesh's, or those in their place
  int32_t prim_id = 0, instance_id = 0;
  const SubsurfaceBody* body = nullptr;  // where light goes below this surface; null: no material of it scatters
  uint32_t member = 0;                   // of the body
  uint32_t clear_rank = 0;               // among clear bodies: see rank_clear_bodies()
  bool see_through = false;              // rays may pass some hits: partly opaque, single-sided, or culled
  bool single_sided = false;             // of some material slot
  MeshOptions options;
  std::vector<uint8_t> single_sided_slots;  // those whose back rays pass are not 0; empty: not single_sided
  uint32_t category_set = 0;                // of SceneSnapshot
  uint32_t light_group = 0;                 // the same, from 1 on; 0: of none
  TangentCache::Tangents tangents;          // for normal maps
  /// Normal maps whose coordinates differ from those of `tangents` have their own. By address.
  std::vector<std::pair<const NormalMap*, TangentCache::Tangents>> own_tangents;
  const InstanceArray* array = nullptr;      // this is the look of all its instances; null: of one alone
  InstanceValuesPtr values;                  // of each instance, by id_of()
  std::shared_ptr<const InstanceEnds> ends;  // null: it stands still, or nobody asks

  /// Where the instance that was hit stands at the hit's time. `moved` holds the answer if it moves or is of an array.
  const Placement& at(const TriangleHit& hit, std::optional<Placement>* moved) const {
    return stands_alone() ? *this : place(hit, moved);
  }
  const Placement& place(const TriangleHit& hit, std::optional<Placement>* moved) const;
  bool stands_alone() const { return poses.empty() && !array; }
  int32_t id_of(const TriangleHit& hit) const;
  /// For a material at a hit. `uv`: of the mesh's first set.
  HitPrimvars primvars_at(const TriangleHit& hit, const Vec2f& uv, const SurfaceFootprint& footprint = {}) const {
    InstanceOf of;
    if (values) [[unlikely]]
      of = {values.get(), static_cast<size_t>(id_of(hit))};
    return {prototype->mesh, hit, uv, footprint, of};
  }
  bool is_still() const { return poses.empty() && !prototype->mesh.deforms(); }

  /// The material slot of a triangle; slots beyond the list use the first.
  size_t slot(uint32_t triangle) const {
    const auto slot = slots->empty() ? size_t(0) : static_cast<size_t>((*slots)[triangle]);
    return slot < materials.size() ? slot : 0;
  }
  const DisneyMaterial& material(uint32_t triangle) const { return *materials[slot(triangle)]; }
  /// For a map of one of the materials; null: the mesh has none.
  const MeshAttribute<Vec4f>* tangents_for(const NormalMap& map) const {
    const auto is_before = [](const auto& own, const NormalMap* wanted) { return std::less<>()(own.first, wanted); };
    const auto own = std::lower_bound(own_tangents.begin(), own_tangents.end(), &map, is_before);
    return own != own_tangents.end() && own->first == &map ? own->second.get() : tangents.get();
  }
  /// Rays pass the back of the slot's triangles.
  bool is_single_sided(size_t slot) const { return single_sided && single_sided_slots[slot] != 0; }
};

/// The instances of an array have the indices from `first` on.
struct InstanceArray {
  Instance look;
  uint32_t first = 0;
  std::shared_ptr<const PlacedArray> placed;
};

/// True if a ray along `dir` meets the triangle from behind, the side from which it winds clockwise.
bool is_behind(const Instance& instance, const TriangleHit& hit, const Vec3f& dir);

/// Immutable. Render space = world - origin: the origin is in the middle of the scene (choose_origin()), so that
/// precision does not depend on where in the world a scene stands.
struct SceneSnapshot {
  uint64_t number = 0;
  Vec3d origin{0, 0, 0};
  float radius = 0;  // of a sphere about the render-space origin that holds all geometry
  SceneFeatures features;
  Bounds clear_bodies;                // of all instances that have an interior which light may go through
  Bounds clear_meetings;              // where their boxes meet each other, or those of opaque surfaces
  std::vector<Instance> instances;    // those that stand alone, and have the first indices
  std::vector<InstanceArray> arrays;  // in the order of their indices; addresses stay
  std::shared_ptr<const InstancedScene> top;
  LightSet lights;                                             // all
  std::vector<std::shared_ptr<const LightSet>> linked_lights;  // by category set; empty: all light everything
  std::vector<std::vector<bool>> shadow_casters;               // by shadow link, less 1, and category set
  std::vector<std::string> light_groups;                       // of SceneDescription
  std::vector<std::string> left_out;  // names of instances and lights that are too far away, too large or not finite
  std::vector<std::string> faults;    // of the scale, and of sets of images that lack one that is needed
  size_t memory_bytes = 0;            // of meshes, their interiors, trees, lights and textures, each counted once
  std::shared_ptr<MemoryReservation> memory;  // of instances and lights; other parts hold their own

  /// The instance that a hit's index names; the look, where it is in an array.
  const Instance& instance(uint32_t index) const { return index < instances.size() ? instances[index] : look(index); }
  const Instance& look(uint32_t index) const;
  size_t instance_count() const;

  /// Those that light an instance: its surfaces, and where light enters its body.
  const LightSet& lights_of(const Instance& instance) const {
    return linked_lights.empty() ? lights : *linked_lights[instance.category_set];
  }
  bool casts_shadow(const Instance& instance, uint32_t shadow_link) const {
    return shadow_link == 0 || shadow_casters[shadow_link - 1][instance.category_set];
  }

  std::vector<std::shared_ptr<SubsurfaceBody>> bodies;           // keep-alive
  std::vector<std::shared_ptr<const MeshPrototype>> prototypes;  // keep-alive
  std::vector<std::shared_ptr<const DisneyMaterial>> materials;  // keep-alive
  std::vector<std::shared_ptr<const TriangleSlots>> slots;       // keep-alive
};

/// The numbers of materials in AOV materialId, by address in order.
using MaterialNumbers = std::shared_ptr<const std::vector<std::pair<const DisneyMaterial*, int32_t>>>;
/// By primId, the number of the matte of the first of a prim's instances, which the others' follow; -1: all have one
/// matte, whose number is the primId.
using InstanceMattes = std::shared_ptr<const std::vector<int32_t>>;

/// One that shares nothing with others (SnapshotCompiler). Null when Embree refuses (reported). Throws std::bad_alloc.
std::shared_ptr<const SceneSnapshot> compile_snapshot(const SceneDescription& description, uint64_t number,
                                                      const std::shared_ptr<TraceDevice>& device,
                                                      const DiagnosticSink& sink);

}  // namespace alabaster
