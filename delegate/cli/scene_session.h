// A loaded scene together with the delegate that renders it, taken down in the right order.
#pragma once

#include <memory>

#include "delegate/cli/console.h"
#include "delegate/description/render_description.h"

namespace alabaster::cli {

class SceneSession {
 public:
  /// `is_posed`: keeps the scene's files open, for pose().
  explicit SceneSession(bool is_posed = false) : is_posed_(is_posed) {}
  ~SceneSession();

  hd::host::RetainedSceneDelegate scene;
  hd::description::SceneFile file;

  // These end the command after a report of why.
  void load(const std::string& name, const hd::description::LoadOptions& options, const hd::DiagnosticSink& sink);
  /// Those that the scene was loaded with.
  const hd::description::LoadOptions& options() const { return options_; }
  /// Gives the models of the loaded scene the pose of LoadOptions::time `time`. The default look stays as it was
  /// loaded.
  void pose(double time, const hd::DiagnosticSink& sink);
  /// Chooses the colour configuration: `asked`, or the scene's if that is empty. `code`: of one that cannot be used.
  void choose_colors(const std::string& asked, const hd::DiagnosticSink& sink, int code);
  /// The configuration that was chosen.
  const hd::host::OutputColors& colors() const { return colors_; }
  /// Removes materials that no mesh uses, makes the delegate and the index, and populates the index.
  void start(const hd::DiagnosticSink& sink);
  /// After a Sync: ends the command if the scene has faults, which have been reported.
  void require_whole() const;

  hd::RenderDelegate* delegate() const { return delegate_.get(); }
  hd::host::RenderIndex* index() const { return index_.get(); }

 private:
  struct Destroy {
    void operator()(hd::RenderDelegate* delegate) const { DestroyAlabasterRenderDelegate(delegate); }
  };
  void remove_unused_materials();

  const bool is_posed_;
  hd::description::SceneSource source_;
  hd::description::LoadOptions options_;
  hd::host::OutputColors colors_;
  std::unique_ptr<hd::RenderDelegate, Destroy> delegate_;
  std::unique_ptr<hd::host::RenderIndex> index_;
};

}  // namespace alabaster::cli
