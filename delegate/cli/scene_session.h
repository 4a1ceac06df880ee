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
  /// Whether the colour configuration that counts can be used; `asked` comes before the scene's. False after a report.
  bool choose_colors(const std::string& asked, const hd::DiagnosticSink& sink);
  /// The configuration that was chosen.
  const hd::host::OutputColors& colors() const { return colors_; }
  /// Makes the delegate and the index, and fills it. False after a report.
  bool start(const hd::DiagnosticSink& sink);

  hd::RenderDelegate* delegate() const { return delegate_.get(); }
  hd::host::RenderIndex* index() const { return index_.get(); }

 private:
  struct Destroy {
    void operator()(hd::RenderDelegate* delegate) const { DestroyAlabasterRenderDelegate(delegate); }
  };
  hd::host::OutputColors colors_;
  std::unique_ptr<hd::RenderDelegate, Destroy> delegate_;
  std::unique_ptr<hd::host::RenderIndex> index_;
};

/// The exit code of a load that failed with `error`: what the command line asked for in `options` carries its own text
/// as the place, and a fault there is one of usage; a file that is missing or unreadable is input wherever it is named.
int load_failure(const hd::Diagnostic& error, const hd::description::LoadOptions& options);

}  // namespace alabaster::cli
