#include "delegate/cli/scene_session.h"

namespace alabaster::cli {

SceneSession::~SceneSession() {
  if (index_) scene.Depopulate();
  index_.reset();
  delegate_.reset();
}

bool SceneSession::load(const std::string& name, const hd::description::LoadOptions& options,
                        const hd::DiagnosticSink& sink) {
  file = hd::description::LoadScene(name, &scene, sink, options);
  return file.ok;
}

bool SceneSession::start(const std::string& ocio, const hd::DiagnosticSink& sink) {
  hd::DelegateOptions options;
  options.diagnostics = sink;
  if (!ocio.empty()) options.settings["ocio"] = ocio;
  delegate_.reset(CreateAlabasterRenderDelegate(hd::kAbiVersion, &options));
  if (!delegate_) return false;
  index_ = std::make_unique<hd::host::RenderIndex>(delegate_.get());
  scene.Populate(index_.get());
  return true;
}

}  // namespace alabaster::cli
