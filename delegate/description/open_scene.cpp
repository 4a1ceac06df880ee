// Loads a scene, and poses it again.
#include <exception>
#include <functional>

#include "core/math/float_environment.h"
#include "delegate/description/load_state.h"
#include "delegate/support/lookup.h"

namespace alabaster::hd::description {
struct OpenScene::State {
  std::string file;
  host::RetainedSceneDelegate* scene = nullptr;
  SceneFile result;
  LoadState state;

  // Reports what is thrown, too.
  LoadCause run_guarded(const DiagnosticSink& sink, const std::function<void()>& work) {
    const FloatEnvironment environment;
    std::string fault, code = "scene.memory";
    state.sink = &sink, state.cause = LoadCause::none;
    state.scene = scene, state.posing = false, state.names.clear();
    try {
      work();
      return LoadCause::none;
    } catch (const LoadFailed&) {
      state.note_cause(LoadCause::input);
      return state.cause;
    } catch (const MemoryRefused& e) {
      fault = e.what();
    } catch (const std::bad_alloc&) {
      fault = "Not enough memory to load the scene.";
    } catch (const std::exception& e) {
      fault = std::string("The scene could not be loaded: ") + e.what(), code = "scene.load";
    }
    if (sink) sink({Severity::error, code, file, fault});
    return code == "scene.memory" ? LoadCause::out_of_memory : LoadCause::input;
  }

  void pose(const LoadOptions& at) {
    // What the models have now is edited as a scene of its own, and shown once nothing can fail any more.
    host::RetainedSceneDelegate posed;
    std::vector<Path> removed;
    for (const auto& model : state.models) {
      host::SceneEdits edits;
      const host::SourceFault fault = model->pose(model->time_of(at), *state.sink, &edits);
      if (fault == host::SourceFault::out_of_memory) state.note_cause(LoadCause::out_of_memory);
      if (fault != host::SourceFault::none) throw LoadFailed();
      model->place(&edits);
      // Render settings are planned when a scene is loaded, and stay.
      std::erase_if(edits.prims,
                    [](const auto& prim) { return std::holds_alternative<RenderSettingsDescription>(prim.second); });
      removed.insert(removed.end(), edits.removed.begin(), edits.removed.end());
      edits.removed.clear();
      if (model->apply(std::move(edits), *state.sink, &posed) != host::SourceFault::none) throw LoadFailed();
    }
    state.scene = &posed, state.posing = true;
    edit_prims(state);
    if (state.studio_is_alone) remove_lights(&posed, false);

    state.scene = scene, state.posing = false;
    for (const auto& [path, prim] : posed.GetPrims()) {
      scene->Set(path, prim);
      scene->SetName(path, support::value_in(posed.GetNames(), path));
    }
    for (const Path& path : removed) scene->Remove(path);
    for (const auto& model : state.models) model->shown();
    pose_camera(&state);
  }
};

OpenScene::OpenScene() = default;
OpenScene::~OpenScene() = default;
OpenScene::OpenScene(OpenScene&&) noexcept = default;
OpenScene& OpenScene::operator=(OpenScene&&) noexcept = default;

SceneFile OpenScene::Load(const std::string& file, host::RetainedSceneDelegate* scene, const DiagnosticSink& sink,
                          const LoadOptions& options) {
  SceneFile result;
  try {
    open_ = std::make_unique<State>();
    open_->file = file;
  } catch (const std::bad_alloc&) {
    open_.reset();
    if (sink) sink({Severity::error, "scene.memory", file, "Not enough memory to load the scene."});
    result.cause = LoadCause::out_of_memory;
    return result;
  }
  LoadState& state = open_->state;
  state.options = options;
  state.result = &open_->result;
  open_->scene = scene;
  open_->result.cause = open_->run_guarded(sink, [&] { return load_scene(file, &state); });
  open_->result.ok = open_->result.cause == LoadCause::none;
  result = open_->result;
  if (!result.ok) open_.reset();
  return result;
}

LoadCause OpenScene::pose(const LoadOptions& at, const DiagnosticSink& sink) {
  const DiagnosticSink errors = [&sink](const Diagnostic& diagnostic) {
    // A stage's reader tells each kind of thing once, also what a later time has first.
    if ((diagnostic.severity == Severity::error || diagnostic.code == "usd.unread") && sink) sink(diagnostic);
  };
  return open_ ? open_->run_guarded(errors, [&] { return open_->pose(at); }) : LoadCause::input;
}

LoadCause OpenScene::Pose(double time, const DiagnosticSink& sink) {
  LoadOptions at;
  at.time = time;
  return pose(at, sink);
}

LoadCause OpenScene::PoseFrame(double frame, const DiagnosticSink& sink) {
  LoadOptions at;
  at.frame = frame;
  return pose(at, sink);
}

SceneFile LoadScene(const std::string& file, host::RetainedSceneDelegate* scene, const DiagnosticSink& sink,
                    const LoadOptions& options) {
  return OpenScene().Load(file, scene, sink, options);
}

}  // namespace alabaster::hd::description
