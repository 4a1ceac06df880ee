// From a mesh as its prim has pulled it to the BVH that is traced.
#pragma once

#include "core/camera/camera.h"
#include "core/diagnostics/cancel.h"
#include "core/geometry/edited_object.h"
#include "delegate/prims/scene_param.h"

namespace alabaster::hd::prims {

/// The refined shape of a mesh that deforms, at the times of its samples.
struct Deformation {
  std::vector<double> times;
  std::vector<MeshPose> poses;
  MemoryReservation memory = {};
};

struct BuiltMesh {
  std::shared_ptr<const MeshPrototype> prototype;  // null: nothing to draw
  std::shared_ptr<const Deformation> deformation;  // null: the prototype's shape is that of all times
  std::shared_ptr<const TriangleSlots> slots;      // in the place of the prototype's; null: those
  std::optional<std::string> fault;
  bool reported = false;  // something about the mesh, be it a warning
};

/// The picture by which adaptive refinement measures.
struct Dicing {
  float edge_length = 0;  // pixels; 0: meshes are refined by their refineLevel
  CameraParameters camera;
  int width = 0, height = 0;
  bool operator==(const Dicing&) const = default;
};

/// Beside the mesh itself, all that decides what it becomes.
struct MeshRequest {
  Displacements displacements;
  NamedPrimvars primvars;
  Dicing dicing;
  std::vector<Matrix4d> placements;  // object to world of its instances; empty without dicing
  bool operator==(const MeshRequest&) const = default;
};

/// The parts of a mesh that its next shape uses again, where its points are edited.
struct PointEdits {
  explicit PointEdits(const std::shared_ptr<MemoryBudget>& budget)
      : shells(std::make_shared<ShellTopologyCache>(budget)) {}
  void rest() {
    object.rest();
    shells->forget();
  }

  EditedObject object;
  std::shared_ptr<ShellTopologyCache> shells;
  std::weak_ptr<const MeshPrototype> before;  // as it was built last
};

/// A mesh to build. Immutable, but for `edits`, which one build at a time may use.
struct MeshJob {
  Path path;
  std::shared_ptr<const PulledMesh> source;
  std::shared_ptr<const FaceSlots> slots;
  MeshRequest request;
  std::shared_ptr<PointEdits> edits;  // null: none so far
  std::optional<BuiltMesh> shape;     // the same mesh with other slots: only those are built
};

struct MeshResult {
  BuiltMesh built;
  std::vector<alabaster::Diagnostic> reports;  // faults of the mesh
};

/// In the caller's arena. Throws BuildCancelled and std::bad_alloc.
MeshResult build_mesh_job(const MeshJob& job, SceneParam* param, const CancelToken& cancel);

}  // namespace alabaster::hd::prims
