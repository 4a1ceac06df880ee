// A pass: compares what it is asked to draw with what it is drawing, and drives one RenderSession.
#pragma once

#include "core/session/render_session.h"
#include "delegate/rendering/delegate_state.h"
#include "delegate/rendering/framing.h"
#include "delegate/rendering/render_buffer.h"

namespace alabaster::hd::rendering {

/// The parts of a pass's state for which the scene is built.
struct PassView {
  support::Selection selection;
  std::optional<Shutter> shutter;  // of a free camera
  std::vector<Token> primvars;     // that AOVs show
  bool shows_motion = false;       // AOV motion is among them
  bool operator==(const PassView&) const = default;
};

/// Everything that a render depends on: if two are equal, nothing restarts.
struct PassInputs {
  std::shared_ptr<const SceneSnapshot> scene;
  FramedCamera framed;
  RenderSettings settings;
  struct Binding {
    Aov aov = Aov::color;
    std::shared_ptr<BufferState> buffer;
    uint64_t allocation = 0;
    Value clear;
    int plane = 0;  // of an AOV of ids the pair of ranks, of light groups the group
    bool operator==(const Binding&) const = default;
  };
  std::vector<Binding> bindings;
  std::vector<UvSetName> primvars;           // of AOVs, by their place
  std::vector<std::string> light_groups;     // the same
  std::shared_ptr<const Denoiser> denoiser;  // null: no binding shows its picture
  bool shows_checkpoint = false;             // instead of the scene
  uint64_t restarts = 0;
  std::string error;     // why nothing can be drawn; empty: it can
  bool refused = false;  // because of what was asked for
  bool operator==(const PassInputs&) const = default;
};

/// The part of a pass that Stop, Pause, Resume and GetRenderStats reach from any thread.
class PassControl : public std::enable_shared_from_this<PassControl> {
 public:
  explicit PassControl(std::shared_ptr<DelegateState> delegate);
  ~PassControl() { session_->stop(); }

  void execute(const RenderPassState& state);  // host thread
  /// Draws what Execute requested while the scene was being built, if that has ended. False: it has not. Any thread.
  bool start_deferred();
  /// The host destroys the pass: no render begins any more.
  void retire();
  /// Empty: it has not been executed.
  std::optional<PassView> view() const;
  /// That it was drawn of last; null: none, or that could not be built.
  std::shared_ptr<const BuiltScene> scene() const;
  /// A new scene is being built: the picture does not converge before it, though the old one is rendered on.
  void expect_new_scene();
  void abandon();     // Execute threw: the pass fails and converges
  void stop();        // Stop: blocks until no worker runs
  void invalidate();  // Restart: the next Execute starts again
  void pause();
  void resume();
  /// Waits for the scene, too. The next Execute after it returned true reports convergence.
  bool wait(double seconds);

  PassState state() const;
  bool is_converged() const { return converged_ && !picture_stale_; }
  /// The request was at fault, and nothing was rendered: framing, camera, or more memory than the limit leaves.
  bool is_refused() const { return refused_; }
  RenderProgress progress() const { return session_->progress(); }
  void ask_for_noise() { session_->ask_for_noise(); }
  /// RenderSession::save().
  bool save(const BlockSink& sink) { return session_->save(sink); }
  std::string error() const;
  /// The camera that is or was rendered last, framed. Empty: there is none, or a checkpoint is shown.
  std::optional<CameraParameters> camera() const;
  /// Bytes of the film that is or was rendered last.
  size_t film_memory() const;

 private:
  /// The arguments of Execute, and the buffers of its bindings, which the host may destroy before the scene is built.
  /// A null buffer is none of this delegate.
  struct DrawRequest {
    RenderPassState state;
    std::vector<std::shared_ptr<BufferState>> buffers;
  };
  void set_view(const RenderPassState& state);
  void draw(const DrawRequest& asked);
  /// `waits`: the scene is an earlier one, until that which is wanted has been built.
  PassInputs inputs(const DrawRequest& asked, const BuiltScene* scene, bool waits,
                    std::vector<alabaster::Diagnostic>* faults);
  void add_bindings(const DrawRequest& asked, bool waits, PassInputs* in, std::vector<alabaster::Diagnostic>* faults);
  std::optional<CameraParameters> camera_of(const RenderPassState& state, const Path& path,
                                            const prims::Translation* scene) const;
  void choose_denoiser(PassInputs* in);
  void update(PassInputs next, bool building, std::vector<alabaster::Diagnostic>* faults);
  void start(PassInputs next);
  void note_start();
  /// Takes up the end of the session; the error of a failure that is new.
  std::string see_end();
  void fail(std::string error);
  void set_converged(bool converged);

  std::shared_ptr<DelegateState> delegate_;
  std::shared_ptr<RenderSession> session_;

  std::mutex control_;  // one at a time drives the session; never held while reporting or waiting for a frame
  PassInputs running_;
  std::atomic<bool> active_{false};  // running_ is being or has been drawn by session_
  std::atomic<bool> cancelled_{false};
  bool finish_seen_ = false;
  std::atomic<bool> converged_{false}, failed_{false}, refused_{false};
  mutable std::mutex view_mutex_;
  std::optional<PassView> view_;
  std::shared_ptr<const BuiltScene> scene_;       // under view_mutex_
  std::optional<CameraDescription> free_camera_;  // of the last Execute, under executing_ as its record
  prims::CameraRecord free_record_;
  prims::KnownFaults free_faults_;
  mutable std::mutex error_mutex_;
  std::optional<CameraParameters> camera_;  // under error_mutex_
  std::string error_;
  std::mutex executing_;  // one thread at a time draws: the host's, one in wait(), or the builder's
  std::vector<std::pair<std::string, std::string>> reported_;  // faults of the last Execute
  std::optional<DrawRequest> deferred_;                        // is drawn once the scene is built
  MemoryReservation frame_memory_;                             // of the frame that is or was drawn last
  std::atomic<bool> executed_{false};
  /// A newer scene than that of running_ is being built, or Execute has not seen it.
  std::atomic<bool> picture_stale_{false};
};

/// The part of GetRenderStats that is a pass's own, to be kept when the pass is gone.
Dictionary pass_stats(const PassControl& pass);

class RenderPassImpl final : public RenderPass {
 public:
  explicit RenderPassImpl(std::shared_ptr<DelegateState> delegate);
  ~RenderPassImpl() override;
  void Execute(const RenderPassState& state) override;
  bool IsConverged() const override { return control_->is_converged(); }
  PassState GetState() const override;
  bool WaitForConvergence(double seconds) override;

 private:
  std::shared_ptr<DelegateState> delegate_;
  std::shared_ptr<PassControl> control_;
};

}  // namespace alabaster::hd::rendering
