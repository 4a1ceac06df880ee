// A loaded scene together with the delegate that renders it, taken down in the right order.
#pragma once

#include <memory>

#include "delegate/cli/console.h"
#include "delegate/description/render_description.h"

namespace alabaster::cli {

class SceneSession {
 public:
  ~SceneSession();

  hd::host::RetainedSceneDelegate scene;
  hd::description::SceneFile file;

  /// False after a report.
  bool load(const std::string& name, const hd::description::LoadOptions& options, const hd::DiagnosticSink& sink);
  /// Makes the delegate and the index, and fills it. False after a report.
  bool start(const std::string& ocio, const hd::DiagnosticSink& sink);

  hd::RenderDelegate* delegate() const { return delegate_.get(); }
  hd::host::RenderIndex* index() const { return index_.get(); }

 private:
  struct Destroy {
    void operator()(hd::RenderDelegate* delegate) const { DestroyAlabasterRenderDelegate(delegate); }
  };
  std::unique_ptr<hd::RenderDelegate, Destroy> delegate_;
  std::unique_ptr<hd::host::RenderIndex> index_;
};

}  // namespace alabaster::cli
