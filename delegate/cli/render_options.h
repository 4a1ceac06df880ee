// The options of render as the command uses them: loading, frames, checkpoints. main.cpp adds them to the parser.
#pragma once

#include <string>

#include "delegate/cli/commands.h"
#include "delegate/cli/scene_session.h"
#include "delegate/host/frame_recorder.h"

namespace alabaster::cli {

/// The number of a single frame, in statistics.
uint32_t frame_number(const hd::RenderSettingsDescription& settings);

/// The first frame's, where there are --frames.
hd::description::LoadOptions load_options(const RenderArguments& a);

/// "noise: 2.00 % relative RMSE ..." of a render's statistics; empty if the noise is not known.
std::string noise_text(const hd::Dictionary& stats);

// Checkpoints, and parts of a frame. These end the command after a message.
/// Checks that the checkpoints can be written, and that none would be lost.
void check_checkpoint_files(const RenderArguments& arguments, Console& console);
/// Checks them against the scene. `renders`: how many it describes.
void check_parts(const RenderArguments& arguments, const SceneSession& session, size_t renders, Console& console);
/// Checks that a frame of these settings can be rendered in parts. `option`: that which asks for parts.
void check_divisible(const char* option, const SceneSession& session, Console& console);

/// The files of all frames; none without --checkpoint.
std::vector<std::string> checkpoint_files(const RenderArguments& arguments);
/// Sets the options of the recording of a frame. `number`: by --frames.
void set_checkpoint(const RenderArguments& arguments, double number, Console& console,
                    hd::host::RecordOptions* options);
/// Takes the products from the scene, for a part that writes no picture, and returns their AOVs, which its sum will
/// need.
std::vector<std::string> take_part_aovs(const RenderArguments& arguments, SceneSession* session,
                                        std::vector<hd::RenderProduct>* of_frame);

}  // namespace alabaster::cli
