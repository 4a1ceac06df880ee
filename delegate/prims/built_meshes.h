// The meshes of a scene as they are traced.
#pragma once

#include "delegate/prims/equal_meshes.h"
#include "delegate/prims/mesh_build.h"
#include "delegate/support/lookup.h"
#include "delegate/support/selection.h"

namespace alabaster::hd::prims {

/// The demands of all passes on meshes.
struct MeshView {
  Dicing dicing;
  std::vector<Token> primvars;  // that AOVs show; sorted
  bool operator==(const MeshView&) const = default;
};

/// The built meshes of a scene. A mesh is built where it is first drawn, again when its shape, its displacement or its
/// dicing changes, and kept until then, also while no selection includes it. Other material slots of its faces build
/// nothing again, and meshes of equal geometry share what is built of the first. One thread at a time.
class BuiltMeshes {
 public:
  struct Scene {
    const Records& records;
    const support::Selection& selection;
    const MeshView& view;
  };
  /// Builds those that are missing, in the delegate's arena. A mesh that cannot be built is reported and not drawn.
  /// Meshes that are done are kept when the build is cancelled (BuildCancelled) or memory for one is refused
  /// (MemoryRefused). A build of a large mesh may take some tenths of a second to end.
  void build(const Scene& scene, SceneParam* param, const CancelToken& cancel);
  /// Frees the meshes that are gone or were built again, which the last build() put aside.
  void release_dropped() { dropped_.clear(); }
  /// No edits are expected for now, or memory has run out: frees what would make edits of points quick.
  void rest();
  class Lookup;
  template <class Visit>
  void for_each(const Visit& visit) const {
    for (const auto& [path, held] : held_)
      if (held.done) visit(path, held.built);
  }
  SceneFaults faults(const Records& records, const support::Selection& selection) const;

 private:
  struct Held {
    std::shared_ptr<const MeshJob> job;
    BuiltMesh built;
    bool done = false;
    bool has_shape = false;                       // `built` may serve other slots, and meshes of equal geometry
    std::shared_ptr<PointEdits> edits = nullptr;  // null: none so far
    int unedited_builds = 0;                      // since the last edit
    uint64_t collection = 0;                      // the last one that has kept it
    KnownFaults faults = {};
  };
  using Entry = std::pair<const Path, Held>;
  std::vector<Entry*> collect(const Scene& scene, const std::shared_ptr<MemoryBudget>& budget);
  Held make_held(MeshJob job, const Held* before, bool same_shape, const std::shared_ptr<MemoryBudget>& budget) const;
  void drop_all_but(size_t kept);
  static void adopt(Held* held, MeshResult result, const alabaster::DiagnosticSink& sink);
  std::vector<Entry*> build_first(const std::vector<Entry*>& to_build, SceneParam* param, const CancelToken& cancel);
  void build_batch(const std::vector<Entry*>& to_build, SceneParam* param, const CancelToken& cancel);
  std::shared_ptr<PointEdits> edits_after(const Held& from, const MeshJob& next,
                                          const std::shared_ptr<MemoryBudget>& budget) const;

  std::map<Path, Held> held_;
  uint64_t collections_ = 0;  // so far
  std::vector<Held> dropped_;
};

/// Finds built meshes by paths in ascending order.
class BuiltMeshes::Lookup {
 public:
  explicit Lookup(const BuiltMeshes& meshes) : held_(meshes.held_) {}
  /// Null: it has not been built.
  const BuiltMesh* find(const Path& mesh) {
    const Held* const held = held_.find(mesh);
    return held && held->done ? &held->built : nullptr;
  }

 private:
  support::AscendingLookup<const std::map<Path, Held>> held_;
};

}  // namespace alabaster::hd::prims
