// The state that a delegate shares with its passes: settings, the committed scene and its snapshot, background control.
#pragma once

#include "core/scene/snapshot_compiler.h"
#include "core/session/tile_renderer.h"
#include "delegate/prims/deformation.h"
#include "delegate/prims/mesh_build.h"
#include "delegate/prims/parameters.h"
#include "delegate/prims/render_param.h"
#include "delegate/prims/scene_translation.h"

namespace alabaster::hd::rendering {

class PassControl;

class RenderCore {
 public:
  RenderCore(std::shared_ptr<prims::SceneParam> scene_param, const Dictionary& initial_settings);

  const std::shared_ptr<prims::SceneParam> param;

  // Settings. Layers: defaults < the RenderSettings prim < SetRenderSetting.
  void set_setting(const Token& key, const Value& value);
  Value setting(const Token& key) const;
  uint32_t settings_version() const;
  RenderSettings render_settings() const;
  Path settings_camera() const;

  // The scene (host thread).
  /// Applies the edit transaction; if what is drawn changed, compiles and publishes a new snapshot and cancels the
  /// renders of the old one. A scene that could not be compiled leaves no snapshot and a commit_error(). Whatever an
  /// earlier commit could not do, for want of memory or threads, the next one does. Never throws.
  void commit();
  /// Edits were posted since the last commit, or there was none. False after a commit that failed: only the host's
  /// CommitResources tries again, for a pass would compile the scene again with every Execute.
  bool needs_commit() const { return param->has_edits() || !committed_ || dicing_changed_; }
  std::string dump() const;
  std::string requirements() const;
  /// In the shutter of the scene that was committed last. Empty: there is no such camera.
  std::optional<CameraParameters> camera(const Path& path) const;
  /// Loads the library at the first call. Null, with the reason in *problem, if it cannot be used.
  std::shared_ptr<const Denoiser> denoiser(std::string* problem);

  // Any thread.
  std::shared_ptr<const SceneSnapshot> snapshot() const;
  std::string commit_error() const;
  /// One line for each fault of the scene that was reported and not mended since. *input: none of them is for want of
  /// memory.
  std::vector<std::string> scene_faults(bool* input) const;
  double commit_seconds() const { return commit_seconds_; }

  // The frame that was started last (host thread); null: none since the scene was edited.
  void set_last_request(const RenderRequest& request) { last_request_ = std::make_shared<RenderRequest>(request); }
  std::shared_ptr<const RenderRequest> last_request() const { return last_request_; }

  // Passes and background control (any thread).
  void add_pass(const std::shared_ptr<PassControl>& pass);
  std::vector<std::shared_ptr<PassControl>> passes() const;
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
  const prims::SettingsRecord* settings_prim() const;
  prims::Dicing dicing() const;
  void apply_edits();
  void update_scene();
  void publish();

  mutable std::mutex mutex_;  // guards settings_, snapshot_ and passes_, for look-ups only
  std::map<Token, Value> settings_;
  uint32_t settings_version_ = 0;
  std::shared_ptr<const SceneSnapshot> snapshot_;
  std::vector<std::weak_ptr<PassControl>> passes_;

  std::list<prims::Edit> edits_;  // taken, but not applied yet. Host thread only, as is the rest of the scene
  prims::Records records_;
  prims::Dicing dicing_;
  prims::DeferredMeshes deferred_;
  prims::SceneTranslator translator_;
  SnapshotCompiler compiler_;
  prims::Deformations deformations_;
  prims::Translation translation_;
  uint64_t scene_number_ = 0;
  std::atomic<bool> dicing_changed_{false};  // by a setting
  bool committed_ = false;                   // once
  bool commit_failed_ = false;               // the last one threw
  bool stale_ = true;                        // the snapshot does not show the records

  std::shared_ptr<const RenderRequest> last_request_;
  std::shared_ptr<const Denoiser> denoiser_;
  std::string denoiser_problem_;

  std::atomic<double> commit_seconds_{0};
  std::atomic<bool> failed_{false};  // the last commit left no snapshot
  std::mutex stop_mutex_;            // one at a time stops or restarts
  bool stop_latched_ = false;        // by Stop, until Restart
  int stop_holds_ = 0;
  std::atomic<bool> stopped_{false}, paused_{false};
  std::atomic<uint64_t> restarts_{0};
};

}  // namespace alabaster::hd::rendering
