// The inputs that decide a picture beside the options of a command: versions, the colour configuration, files. A farm's
// jobs list them, and each task compares the list with its machine.
#pragma once

#include <map>
#include <string>
#include <utility>

#include "delegate/cli/scene_session.h"
#include "delegate/host/input_digests.h"

namespace alabaster::cli {

enum class InputKind { version, variable, colors, lut, file, reader };

/// Values by kind and name. A value is a version, a digest (empty: the file cannot be read), or "=" and the text of a
/// variable (empty: not set).
using PictureInputs = std::map<std::pair<InputKind, std::string>, std::string>;

/// The versions of the program and of its libraries, and the colour configuration with its LUTs and variables.
void add_colors(const hd::host::ColorInputs& colors, PictureInputs* inputs);
/// Open Image Denoise, with which a merge denoises the frame; nothing is added where there is none.
void add_denoiser(PictureInputs* inputs);
/// The files that a loaded scene was read from, and the versions of the libraries that read them.
void add_files(const SceneSession& session, const std::string& scene, PictureInputs* inputs);

/// A line each, in ASCII.
std::string to_text(const PictureInputs& inputs);
/// Empty if it is not such a text.
PictureInputs parse_inputs(const std::string& text);

struct InputDifference {
  std::string where, text;  // the file or element, and the difference with its remedy; both empty: there is none
};
/// The first one between those of a farm and those of this machine. `with_files`: false for a merge, which reads no
/// file of the scene.
InputDifference input_difference(const PictureInputs& farm, const PictureInputs& here, bool with_files);

/// For `--inputs FILE`, once a session has its colours, and its scene where `scene` is not empty: ends the command with
/// a report if anything differs from the list in the file.
void require_inputs(const std::string& file, const SceneSession& session, const std::string& scene, Console* console);

}  // namespace alabaster::cli
