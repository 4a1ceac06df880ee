// The state that a delegate shares with its passes: settings, cameras, the scene that the builder makes, background
// control.
#pragma once

#include <set>

#include "core/session/render_request.h"
#include "delegate/prims/id_names.h"
#include "delegate/rendering/checkpoints.h"
#include "delegate/rendering/snapshot_builder.h"

namespace alabaster::hd::rendering {

class PassControl;

class DelegateState {
 public:
  DelegateState(std::shared_ptr<prims::SceneParam> scene_param, const Dictionary& initial_settings);

  const std::shared_ptr<prims::SceneParam> param;

  // Settings. Layers: defaults < the RenderSettings prim < SetRenderSetting.
  /// All or, where memory runs out, none.
  void set_settings(const Dictionary& settings);
  Value setting(const Token& key) const;
  uint32_t settings_version() const;
  RenderSettings render_settings() const;
  Path settings_camera() const;
  /// A settings prim is new, edited or gone: its limits of memory apply to the Sync of meshes, which precedes the
  /// commit. Host thread.
  void take_up_settings();

  // The scene (host thread).
  /// Takes cameras and settings from the edit transaction, and hands the rest to the builder. A scene that cannot be
  /// built leaves no snapshot and a commit_error(). Whatever an earlier commit could not do, for want of memory or
  /// threads, the next one does. Never throws.
  void commit();
  /// Edits were posted since the last commit, or there was none. False after a commit that failed: only the host's
  /// CommitResources tries again, for a pass would compile the scene again with every Execute.
  bool needs_commit() const { return param->has_edits() || !committed_ || wanted_changed_ || views_changed_; }
  /// A pass of this selection is executed: the next scene is built for it. `view_changed`: PassControl::view() has.
  /// Host thread.
  void note_executed(const support::Selection& selection, bool view_changed);
  /// Has the builder make the scene of a selection that has none, because those of other passes were made. Any thread.
  void build_for(const support::Selection& selection) { builder_.build_for(selection); }
  /// These wait for the builder.
  std::string dump();
  std::string requirements();
  Dictionary names();

  // Any thread.
  /// Loads the library at the first call. Null, with the reason in *problem, if it cannot be used.
  std::shared_ptr<const Denoiser> denoiser(std::string* problem);
  /// The scene that the builder made last, or one that a pass has drawn and that is_current(). Null: none of these.
  std::shared_ptr<const BuiltScene> scene(const support::Selection& selection) const;
  std::shared_ptr<const BuiltScene> scene(const std::shared_ptr<const SceneSnapshot>& snapshot) const;
  /// Nothing was edited since.
  bool is_current(const BuiltScene& scene) const { return scene.version >= version_; }
  /// The scene of the pass that was created last, of those that have been executed.
  std::shared_ptr<const BuiltScene> scene() const;
  std::shared_ptr<const SceneSnapshot> snapshot() const;
  /// The scene as it was committed last is still being built.
  bool is_building() const { return builder_.is_pending(); }
  bool wait_for_build(double seconds) { return builder_.wait(seconds); }
  /// A pass has released a snapshot.
  void release_retired() { builder_.release_retired(); }
  /// Render threads poll it, to notify the builder.
  const std::shared_ptr<DeferredNotifier>& notifier() const { return builder_.notifier(); }
  /// With its poses in the scene's shutter. Empty: there is no such camera.
  std::optional<CameraParameters> camera(const Path& path, const Shutter& of_scene,
                                         const prims::MotionTime& motion = {}) const;
  /// The end of a sentence about a camera that does not exist: the nearest path that one has.
  std::string nearest_camera(const Path& path) const;
  bool has_failed() const { return builder_.has_failed() || failed_; }
  bool has_failed(const support::Selection& selection) const { return builder_.has_failed(selection) || failed_; }
  /// Why a pass has no snapshot; empty if it has one, or may get one.
  std::string commit_error(const SceneSnapshot* snapshot) const;
  /// One line for each fault of the scene that was reported and not mended since. *input: none of them is for want of
  /// memory.
  std::vector<std::string> scene_faults(bool* input) const;
  double commit_seconds() const { return commit_seconds_ + builder_.compile_seconds(); }

  /// Made once for each snapshot.
  std::shared_ptr<const prims::IdNames> names_of(const BuiltScene& scene) const;

  /// The frame that was started last; null: none of a snapshot that is current.
  void set_last_request(const RenderRequest& request, std::weak_ptr<PassControl> pass);
  std::shared_ptr<const RenderRequest> last_request() const;
  /// The pass that started it; null: it is gone.
  std::shared_ptr<PassControl> last_pass() const;

  Checkpoints checkpoints;

  // Passes and background control (any thread).
  void add_pass(const std::shared_ptr<PassControl>& pass);
  std::vector<std::shared_ptr<PassControl>> passes() const;
  void keep_stats_of_last_pass(Dictionary stats);
  Dictionary stats_of_last_pass() const;
  void stop();
  void restart();
  void hold_stopped(int change);  // 1: one more hold, -1: one less
  void pause();
  void resume();
  bool is_stopped() const { return stopped_; }
  bool is_paused() const { return paused_; }
  void end_pause() { paused_ = false; }
  uint64_t restarts() const { return restarts_; }

 private:
  void apply_stops();
  void drop_old_request();
  void start_deferred_passes() noexcept;
  const prims::SettingsRecord* settings_prim() const;  // under mutex_
  prims::Dicing dicing(const Shutter& shutter) const;
  void split_edits();
  void apply_services();
  void hand_over();
  SnapshotBuilder::View wanted_view();
  template <class IsWanted>
  std::shared_ptr<const BuiltScene> find_scene(const IsWanted& is_wanted) const;

  mutable std::mutex mutex_;  // guards what follows, for look-ups only
  std::map<Token, Value> settings_;
  uint32_t settings_version_ = 0;
  prims::Records cameras_and_settings_;  // which no snapshot has
  std::shared_ptr<const RenderRequest> last_request_;
  std::weak_ptr<PassControl> last_pass_;
  std::vector<std::weak_ptr<PassControl>> passes_;
  Dictionary last_pass_stats_;      // of a pass that is gone
  mutable std::mutex names_mutex_;  // guards what follows, while they are made
  mutable std::shared_ptr<const prims::IdNames> names_;
  mutable uint64_t named_version_ = 0;  // of the scene that names_ are of
  mutable support::Selection named_selection_;
  std::mutex denoiser_mutex_;  // guards what follows, while the library is loaded, too
  std::shared_ptr<const Denoiser> denoiser_;
  std::string denoiser_problem_;

  // Host thread only.
  std::list<prims::Edit> edits_;               // taken, but not applied yet
  std::list<prims::Edit> scene_edits_;         // for the builder, not handed over yet
  std::optional<SnapshotBuilder::View> view_;  // handed over last
  support::Selection selection_;               // of the pass that was executed last
  bool committed_ = false;                     // once

  std::atomic<uint64_t> version_{0};         // of view_
  std::atomic<bool> wanted_changed_{false};  // the wanted view, by a setting
  bool views_changed_ = false;
  std::set<Token> shown_primvars_;   // by AOVs of some pass, once
  bool commit_failed_ = false;       // the last one threw
  std::atomic<bool> failed_{false};  // the same, for any thread
  std::atomic<double> commit_seconds_{0};
  std::mutex stop_mutex_;      // one at a time stops or restarts
  bool stop_latched_ = false;  // by Stop, until Restart
  int stop_holds_ = 0;
  std::atomic<bool> stopped_{false}, paused_{false};
  std::atomic<uint64_t> restarts_{0};

  SnapshotBuilder builder_;  // last: its thread ends first
};

}  // namespace alabaster::hd::rendering
