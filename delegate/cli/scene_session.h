// A loaded scene together with the delegate that renders it, taken down in the right order.
#pragma once

#include <memory>
#include <set>

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
  /// Gives the models of the loaded scene the pose of a frame. The default look stays as it was loaded.
  void pose(double frame, const hd::DiagnosticSink& sink);
  /// What the models lack, by LoadOptions::keep_going.
  std::vector<std::string> faults() const;
  /// Chooses the colour configuration: `asked`, or the scene's if that is empty. `code`: of one that cannot be used.
  void choose_colors(const std::string& asked, const hd::DiagnosticSink& sink, int code);
  /// The configuration that was chosen.
  const hd::host::OutputColors& colors() const { return colors_; }
  /// Removes materials that no mesh uses, makes the delegate and the index, and populates the index.
  void start(const hd::DiagnosticSink& sink);
  /// After a Sync: the exit code of the scene's faults, which have been reported; kDone if it has none.
  int fault_code() const;

  hd::RenderDelegate* delegate() const { return delegate_.get(); }
  hd::host::RenderIndex* index() const { return index_.get(); }

 private:
  struct Destroy {
    void operator()(hd::RenderDelegate* delegate) const { DestroyAlabasterRenderDelegate(delegate); }
  };
  void remove_unused_materials();

  const bool is_posed_;
  hd::description::OpenScene source_;
  hd::description::LoadOptions options_;
  hd::host::OutputColors colors_;
  std::unique_ptr<hd::RenderDelegate, Destroy> delegate_;
  std::unique_ptr<hd::host::RenderIndex> index_;
};

/// True of what a studio adds, and of the soft dome.
bool is_added(const hd::host::RetainedSceneDelegate& scene, const hd::Path& path);
/// The box of all visible meshes that were not added.
hd::description::WorldBox objects_box(hd::host::RetainedSceneDelegate& scene);

/// The scene's own file, and the files of its models, images and lights: those of a set of images one by one. Without
/// the colour configuration.
std::set<std::string> scene_files(const SceneSession& session, const std::string& scene);

/// The error message if one of `outputs` is a file that the session has read, under whatever name; else empty.
std::string input_overwritten(const std::vector<std::string>& outputs, const SceneSession& session,
                              const std::string& scene);

}  // namespace alabaster::cli
