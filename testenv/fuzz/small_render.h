// Small renders of fuzzed scenes.
#pragma once

#include <string>

#include "delegate/description/render_description.h"
#include "delegate/host/frame_recorder.h"
#include "testenv/fuzz/fuzz_target.h"

namespace alabaster::fuzz {

/// A folder of this process, which is removed when it ends.
const std::string& scratch_folder();
/// Writes a file in it; returns its path.
std::string scratch_file(const std::string& name, Bytes bytes);

/// Aborts with the text: a promise was broken.
[[noreturn]] void broken(const std::string& promise);

struct SmallRender {
  hd::Path settings = "/settings";
  bool counts_are_ours = true;  // else a file brings counts of its own
  hd::host::RecordOptions options;
};

/// Renders 4 x 4 pixels with one sample. Aborts where a pixel is not finite, or where an error was reported but the
/// status is `done`, or none was but it failed. Settings, size and products of the scene are replaced.
hd::host::RecordResult render_small(hd::host::RetainedSceneDelegate* scene, const SmallRender& render = {});

/// A scene to put things into: camera /camera, dome /dome, settings /settings.
void add_stage(hd::host::RetainedSceneDelegate* scene);
/// A closed cube of 12 triangles with the material, and texture coordinates.
void add_cube(hd::host::RetainedSceneDelegate* scene, const hd::Path& material);

/// Loads a scene file as the program does, renders it small if it could be loaded. Aborts where the answer and the
/// reports contradict each other.
void load_and_render(const std::string& file, const hd::description::LoadOptions& options = {});

}  // namespace alabaster::fuzz
