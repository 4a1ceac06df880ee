// The body that light walks in below a surface: one object alone, or the union of several that scatter as one (the
// members of a subsurfaceSet, the overlapping shells of one mesh, a mesh that is not closed).
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/geometry/bounds_tree.h"
#include "core/geometry/instance_cell.h"
#include "core/math/bounds.h"
#include "core/subsurface/entry_exit.h"
#include "core/subsurface/lit_surface.h"
#include "core/subsurface/mesh_interior.h"

namespace alabaster {

/// Immutable while rays are traced; any thread. The body has a space of its own: render space moved so that `origin` is
/// at zero, which keeps a union precise wherever it stands in the scene. Light in a lone object is traced in the space
/// of its mesh, with directions and distances of the world, so that scatter distances stay world distances under any
/// affine transform.
struct SubsurfaceBody {
  struct Maps {
    Affine to_body, to_object;  // from the mesh's space and back
  };
  struct Member : Maps {    // the maps of one that stands still
    uint32_t instance = 0;  // index into the scene's instances
    const Mesh* mesh = nullptr;
    const MeshShells* shells = nullptr;
    const ObjectScene* object = nullptr;
    std::vector<Affine> poses = {};  // to_body of one that moves: even ones over the shutter
    Bounds bounds;                   // in the body's space, at all times
    /// By the mesh's material slot; null where nothing scatters and where a texture varies the medium.
    std::vector<std::shared_ptr<const MaterialMedia>> media = {};
    /// For sphere steps; null: none, see plan_shortcuts().
    const DistanceGrid* distances = nullptr;
    float least_stretch = 1;       // a world distance is at least this times the mesh's, at any time, of any instance
    bool room_to_guide = true;     // enough mean free paths across for guiding to pay
    bool room_for_spheres = true;  // and for sphere steps
    /// The places of a lone object that is an array of instances; they have the scene's indices from `instance` on.
    /// Null: one instance.
    const InstanceCells* array = nullptr;

    /// At a time. `moved` holds the answer if the member moves.
    const Maps& at(float time, std::optional<Maps>* moved) const {
      return poses.empty() ? *this : move_to(time, moved);
    }
    /// Where the instance stands whose triangle this is, at the hit's time.
    const Maps& at(const TriangleHit& hit, std::optional<Maps>* moved) const {
      return array ? place(hit.instance, moved) : at(hit.time, moved);
    }
    const Maps& move_to(float time, std::optional<Maps>* moved) const;
    const Maps& place(uint32_t instance, std::optional<Maps>* moved) const;
    /// The instance that light comes out of which entered at `entry`.
    uint32_t instance_of(const TriangleHit& entry) const { return array ? entry.instance : instance; }
  };

  std::vector<Member> members;
  /// Traces the members of a union, in their order, and then the contents. Null: a lone object, closed and without
  /// overlaps, that nothing else stands in: its surface is always the end of the medium.
  std::shared_ptr<const InstancedScene> scene;
  /// What stands in the body, by the scene's indices: walks end at its walls.
  std::vector<uint32_t> contents;
  /// Some walls end walks without letting them out, or walks meet lights: contents, lights within, and opaque faces of
  /// a member. With the first two it has a `scene`.
  bool occupied = false;
  bool lights_within = false, opaque_faces = false;
  /// The subsurfaceWeight of its walls differs, or is 0 somewhere.
  bool weighted = false;
  /// Nothing within is nearer than the grid and the boxes say, in the body's space: for sphere steps.
  std::shared_ptr<const DistanceGrid> to_contents;
  Bounds grid_bounds;
  std::vector<Bounds> boxes_within;
  /// A tree of the bounds of its members; null: they are few.
  std::shared_ptr<const BoundsTree> places;
  Vec3f origin{0, 0, 0};  // in render space
  /// A walk that scatters outside has left through an open mesh, and ends. In the mesh's space for a lone object, in
  /// the body's for a union. Empty: not known; such a walk goes on until it is absorbed.
  Bounds bounds;
  /// Bounds of the clear bodies that may touch this one, render space: exits outside of them lead to air.
  Bounds touched;
  /// Some material is partly opaque: rays may be inside the body in air.
  bool has_holes = false;

  /// Null: walks are not guided to light.
  std::shared_ptr<LazyLitSurface> lit;

  bool is_union() const { return scene != nullptr; }
  bool bounds_distances() const;
  /// A lower bound of the distance from a point of the body's space to what stands in it.
  double distance_to_contents(const Vec3f& p) const;

  /// A point just below the surface at an entry, where walks begin: in the mesh's space for a lone object, in the
  /// body's for a union.
  Vec3f below(const SubsurfaceEntry& entry) const;
  /// A point of render space there, for an entry.
  Vec3f to_walk_space(const SubsurfaceEntry& entry, const Vec3f& p) const;
  /// True if a line in direction `direction` (world) leaves the member's shell at a hit, false if it enters.
  bool leaves(uint32_t member, const TriangleHit& hit, const Vec3f& direction) const;
  /// True if a hit on the surface of a union's member lies within another of its closed shells. `direction`: of the
  /// line that met it (world).
  bool is_inner_wall(uint32_t member, TriangleHit hit, const Vec3f& direction) const;
  /// True if a closed shell of a union contains the ray's origin (render space), by the crossings of the whole line
  /// from there on, whatever the ray's tmax.
  bool contains(Ray ray) const;

  /// The surface of a union that a line of direction `direction` has met; `hit` as `scene` answers. Body space.
  Crossed cross(const TriangleHit& hit, const Vec3f& direction) const;
  /// As contains(), in the body's space. Each member is asked by itself: surfaces of several that lie on each other
  /// could not be told apart. `left`: a member whose surface the origin lies outside of, or null.
  bool contains_in_body_space(const Ray& ray, const Member* left) const;
};

/// World distance by which an entry lies below the surface: as far as rounding can displace the surface.
float depth_below_surface(const SurfaceHit& hit, const Affine& object_to_world);

/// True if walks resolve `scatter_distance` where they begin `depth` below the surface. A scattering event nearer than
/// that happens at that depth: a share depth / mfp of the events is off by as much, which is 2e-4 of the light at this
/// limit.
inline float least_resolved(float depth) {
  return 64 * depth;
}
inline bool is_resolved(float scatter_distance, float depth) {
  return scatter_distance > least_resolved(depth);
}

/// The mean free paths that matter for planning shortcuts in a member, over all its materials. World units.
struct MeanFreePaths {
  float longest = 0;        // 0: nothing scatters
  float of_long_walks = 0;  // the longest in a medium where sphere steps are worthwhile; 0: in none

  void extend(const WalkMedium& medium);
};

/// Says which shortcuts pay in each member, by its size in mean free paths, and finds the distance grids that sphere
/// steps need (BuildCancelled). `paths` and `interiors` are in the order of the members. The least stretch of an array
/// is known already.
void plan_shortcuts(const std::vector<MeanFreePaths>& paths, const std::vector<const MeshInterior*>& interiors,
                    SubsurfaceBody* body, const CancelToken& cancel = {});

/// Bounds that a walk in an open mesh may reach: the mesh's, widened by their own diagonal on every side. A ground
/// plane so becomes a half-space, and what goes beyond is ended and counted.
Bounds widened(const Bounds& bounds);

}  // namespace alabaster
