// From a mesh as its prim has pulled it to the BVH that is traced.
#pragma once

#include "core/camera/camera.h"
#include "core/diagnostics/cancel.h"
#include "core/geometry/edited_object.h"
#include "delegate/prims/render_param.h"
#include "delegate/prims/selection.h"

namespace alabaster::hd::prims {

/// The refined shape of a mesh that deforms, at the times of its samples.
struct Deformation {
  std::vector<double> times;
  std::vector<MeshPose> poses;
  MemoryReservation memory = {};
};

struct MeshBuild {
  std::shared_ptr<const MeshPrototype> prototype;  // null: nothing to draw
  std::shared_ptr<const Deformation> deformation;  // null: the prototype's shape is that of all times
  std::shared_ptr<const TriangleSlots> slots;      // in the place of the prototype's; null: those
  std::optional<SceneFault> fault;
  bool reported = false;  // something about the mesh, be it a warning
};

/// The picture by which adaptive refinement measures.
struct Dicing {
  float edge_length = 0;  // pixels; 0: meshes are refined by their refineLevel
  CameraParameters camera;
  int width = 0, height = 0;
  bool operator==(const Dicing&) const = default;
};

/// The demands of all passes on meshes.
struct MeshView {
  Dicing dicing;
  std::vector<Token> primvars;  // that AOVs show; sorted
  bool operator==(const MeshView&) const = default;
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

/// The built meshes of a scene. A mesh is built where it is first drawn, again when its shape, its displacement or its
/// dicing changes, and kept until then, also while no selection includes it. Other material slots of its faces build
/// nothing again. One thread at a time.
class BuiltMeshes {
 public:
  /// Builds those that are missing, in the delegate's arena. A mesh that cannot be built is reported and not drawn; for
  /// want of memory the next build() tries again. Meshes that are done when the build is cancelled (BuildCancelled) are
  /// kept.
  void build(const Records& records, const std::vector<Selection>& selections, const MeshView& view, SceneParam& param,
             const CancelToken& cancel);
  /// No edits are expected for now: frees what would make those of points quick.
  void rest();
  /// Null: it has not been built.
  const MeshBuild* find(const Path& mesh) const;
  template <class Visit>
  void for_each(const Visit& visit) const {
    for (const auto& [path, held] : held_)
      if (held.done) visit(path, held.built);
  }
  bool is_built_for(const MeshView& view) const { return view == view_; }
  /// Memory or threads did not suffice for some mesh: the next build() tries again.
  bool incomplete() const;
  SceneFaults faults(const Records& records, const Selection& selection) const;

 private:
  struct Held {
    std::shared_ptr<const PulledMesh> source;
    std::shared_ptr<const FaceSlots> slots;
    MeshRequest request;
    MeshBuild built;
    bool done = false;
    bool has_shape = false;                       // only the slots are missing
    std::shared_ptr<PointEdits> edits = nullptr;  // null: none so far
    int edits_of_others = 0;                      // since the last one
    KnownFaults faults = {};
  };
  using Entry = std::pair<const Path, Held>;
  std::vector<Entry*> collect(const Records& records, const std::vector<Selection>& selections, const MeshView& view,
                              const std::shared_ptr<MemoryBudget>& budget);

  void keep_edits(const Held& from, const std::shared_ptr<MemoryBudget>& budget, Held* made);

  std::map<Path, Held> held_;
  MeshView view_;
};

}  // namespace alabaster::hd::prims
