// Writes what a window shows as a render description: the scene's own file or description, and the changes to it.
#pragma once

#include <functional>

#include "delegate/description/render_description.h"
#include "delegate/view/scene_edits.h"

namespace alabaster::view {

struct ViewChanges {
  const hd::host::RetainedSceneDelegate* scene = nullptr;
  const hd::description::SceneFile* loaded = nullptr;
  std::string scene_file;                // that was loaded
  hd::description::LoadOptions options;  // that it was loaded with
  std::string ocio;                      // the OpenColorIO config in use; empty: $OCIO's or the built-in one
  Changes materials, lights;
  std::map<std::string, hd::Value> settings;
  std::optional<hd::CameraDescription> camera;            // in place of the scene's
  std::function<bool(const std::string&)> is_input = {};  // true, and reported, for a file that must stay; may be empty
};

/// Writes `file` (.json), whose render shows what the changes show. The lights and the backdrop of a studio, which
/// depend on the first camera, are written out: the backdrop as NAME_backdrop.glb and the image of a soft dome as
/// NAME_dome.hdr beside the file. Names of files are kept where they lie in the file's folder, else made absolute; such
/// a description needs --allow-outside, and a note to the sink says so. False after a report. Each file appears whole.
bool WriteDescription(const ViewChanges& changes, const std::string& file, const hd::DiagnosticSink& sink);

}  // namespace alabaster::view
