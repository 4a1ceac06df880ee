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
  uint64_t version;  // SnapshotBuilder::View::version
  prims::Translation translation;
  std::shared_ptr<const SceneSnapshot> snapshot;  // of the translation
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
    support::Selection selection;
    Shutter shutter;
    prims::MotionTime motion;
    prims::MeshView meshes;
    uint64_t version = 0;  // another one after each edit, and for other times or other demands on meshes
    bool operator==(const View&) const = default;
  };
  /// Asks for the scene after these edits. One thread at a time. The first call starts the thread, and may throw before
  /// anything is taken.
  void post(std::list<prims::Edit>* edits, const View& view);
  /// Asks for the scene as it was posted last, of another selection, unless a build is asked for already. Any thread.
  void build_for(const support::Selection& selection);
  /// Cancels the build and starts no other until it is called with false. Returns when no build is running.
  void set_stopped(bool stopped);

  // Any thread.
  /// The scene as it was posted last has not been built.
  bool is_pending() const { return pending_; }
  /// Blocks until nothing is pending (true), the builder is stopped, or `seconds` have passed.
  bool wait(double seconds);
  /// The last one. Null: none yet, or has_failed().
  std::shared_ptr<const BuiltScene> built() const;
  /// A build has failed, for want of memory or threads, and no later one has succeeded. Reported; the next post() tries
  /// again.
  bool has_failed() const { return failed_; }
  /// The build that failed was for this selection.
  bool has_failed(const support::Selection& selection) const;
  /// Why it failed; empty: not for want of memory.
  std::string refusal() const;
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
  void refuse(const std::bad_alloc& e);
  std::set<Path> used_materials(const std::map<Path, prims::Edit*>& edits) const;
  void read_files(const CancelToken& cancel);
  void apply_edits();
  prims::SceneFaults faults() const;
  void update(const CancelToken& cancel);
  void translate(const CancelToken& cancel);
  void publish(std::shared_ptr<const BuiltScene> scene);
  void destroy_unused();

  const std::shared_ptr<prims::SceneParam> param_;
  const Events events_;

  mutable std::mutex mutex_;
  std::condition_variable wake_, rested_;
  const std::shared_ptr<DeferredNotifier> notifier_;
  std::list<prims::Edit> posted_;
  std::shared_ptr<const View> posted_view_;
  bool requested_ = false, building_ = false, stopped_ = false, quit_ = false, release_ = false;
  std::shared_ptr<const BuiltScene> built_;
  std::string refusal_;
  support::Selection failed_selection_;
  std::vector<std::shared_ptr<const BuiltScene>> retired_;
  std::atomic<bool> pending_{false}, failed_{false}, cancel_{false};
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
  SnapshotCompiler compiler_;
  uint64_t scene_number_ = 0;
  prims::KnownFaults refusals_;

  std::thread thread_;
};

}  // namespace alabaster::hd::rendering
