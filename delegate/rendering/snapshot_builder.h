// The thread that makes snapshots of the scene: it refines meshes, builds their BVHs, resolves paths and compiles,
// while the host continues and the last snapshot is rendered.
#pragma once

#include <condition_variable>
#include <thread>

#include "core/scene/snapshot_compiler.h"
#include "core/session/deferred_notifier.h"
#include "delegate/prims/built_meshes.h"
#include "delegate/prims/deformation.h"
#include "delegate/prims/scene_param.h"
#include "delegate/prims/scene_translation.h"

namespace alabaster::hd::rendering {

/// Immutable.
struct BuiltScene {
  support::Selection selection;
  prims::Translation translation;
  std::shared_ptr<const SceneSnapshot> snapshot;  // of the translation; null: it could not be compiled
  prims::SceneFaults faults;
};

/// An edit cancels the running build by the rule of delegate/manual/embedding.md, "Edits during a render".
class SnapshotBuilder {
 public:
  /// Called on the builder's thread, under no lock. set_stopped(true) waits for them.
  struct Events {
    std::function<void()> published;  // after each new scene
    std::function<void()> built;      // once nothing is pending, also after a build that failed
  };
  SnapshotBuilder(std::shared_ptr<prims::SceneParam> param, Events events);
  ~SnapshotBuilder();  // cancels
  SnapshotBuilder(const SnapshotBuilder&) = delete;
  SnapshotBuilder& operator=(const SnapshotBuilder&) = delete;

  /// All inputs of a build beside the records.
  struct View {
    std::vector<support::Selection> selections{support::Selection()};  // a scene is built for each; no two are equal
    Shutter shutter;
    prims::MeshView meshes;
    bool operator==(const View&) const = default;
  };
  /// Asks for the scenes after these edits. One thread at a time. The first call starts the thread, and may throw
  /// before anything is taken.
  void post(std::list<prims::Edit>* edits, const View& view);
  /// Cancels the build and starts no other until it is called with false. Returns when no build is running.
  void set_stopped(bool stopped);

  // Any thread.
  /// The scenes as they were posted last have not been built.
  bool is_pending() const { return pending_; }
  /// Blocks until nothing is pending (true), the builder is stopped, or `seconds` have passed.
  bool wait(double seconds);
  /// Null: none of this selection yet, or the first build after an edit, or a view, ended in an exception, and no later
  /// one has succeeded.
  std::shared_ptr<const BuiltScene> built(const support::Selection& selection) const;
  /// The one that has this snapshot, or null.
  std::shared_ptr<const BuiltScene> built(const std::shared_ptr<const SceneSnapshot>& snapshot) const;
  /// The last build failed, for want of memory or threads. Reported; the next post() tries again.
  bool has_failed() const { return failed_; }
  /// Wall time of translating and compiling.
  double compile_seconds() const { return compile_seconds_; }
  /// Passes have released scenes: unused ones are destroyed on the builder's thread.
  void release_retired();
  /// Render threads poll it, so that post() need not notify the builder itself.
  const std::shared_ptr<DeferredNotifier>& notifier() const { return notifier_; }

 private:
  void run();
  bool take_work();
  void await_work(std::unique_lock<std::mutex>* lock);
  void build();
  std::set<Path> used_materials(const std::map<Path, prims::Edit*>& edits) const;
  void read_files(const CancelToken& cancel);
  void apply_edits();
  prims::SceneFaults faults(const support::Selection& selection) const;
  /// The scene of a selection, and the compiler of its snapshots.
  struct Variant {
    support::Selection selection;
    SnapshotCompiler compiler;
    bool has_failed;  // the last time, which has been reported
  };
  void update(const CancelToken& cancel);
  void choose_variants(const std::vector<support::Selection>& selections);
  void translate(Variant* variant, const prims::DeformedMeshes& deformed, const CancelToken& cancel);
  std::shared_ptr<const BuiltScene> unedited(const support::Selection& selection) const;
  bool try_compile(Variant* variant, BuiltScene* scene, alabaster::Diagnostic* failure, const CancelToken& cancel);
  void compile(Variant* variant, BuiltScene scene, const std::shared_ptr<const BuiltScene>& drawn,
               const CancelToken& cancel);
  template <class IsSame>
  std::shared_ptr<const SceneSnapshot> find_held(const SceneDescription& scene, const IsSame& is_same) const;
  std::shared_ptr<const SceneSnapshot> snapshot_of(const SceneDescription& scene) const;
  std::shared_ptr<const SceneSnapshot> as_incomplete(const BuiltScene& scene) const;
  void publish(std::shared_ptr<const BuiltScene> scene);
  void retire_unselected();
  bool lacks_snapshots() const;  // under mutex_
  void destroy_unused();

  const std::shared_ptr<prims::SceneParam> param_;
  const Events events_;

  mutable std::mutex mutex_;
  std::condition_variable wake_, rested_;
  const std::shared_ptr<DeferredNotifier> notifier_;
  std::list<prims::Edit> posted_;
  std::shared_ptr<const View> posted_view_;
  bool requested_ = false, building_ = false, stopped_ = false, quit_ = false, release_ = false;
  std::vector<std::shared_ptr<const BuiltScene>> built_;  // by selection
  std::vector<std::shared_ptr<const BuiltScene>> retired_;
  std::atomic<bool> pending_{false}, failed_{false}, lost_{false}, cancel_{false};
  bool cancelled_before_ = false;  // the last build was cancelled by an edit
  std::atomic<double> compile_seconds_{0};

  // The builder's thread only.
  std::list<prims::Edit> edits_;  // taken, but not applied yet, or of materials that no mesh uses
  std::shared_ptr<const View> view_;
  prims::Records records_;
  std::vector<prims::Record> replaced_;  // freed once the new scene stands
  prims::BuiltMeshes meshes_;
  prims::Deformations deformations_;
  prims::SceneTranslator translator_;
  std::vector<Variant> variants_;
  uint64_t scene_number_ = 0;
  bool scenes_stale_ = true;  // the scenes do not show records_ as they are
  bool changed_ = true;       // edits or views have come since the scenes were made
  bool in_vain_ = false;      // a scene stays that lacks parts: the try to add them was no better

  std::thread thread_;
};

}  // namespace alabaster::hd::rendering
