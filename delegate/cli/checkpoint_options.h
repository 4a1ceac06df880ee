// The options of render that have to do with checkpoints and with parts of a frame.
#pragma once

#include "delegate/cli/commands.h"
#include "delegate/cli/scene_session.h"
#include "delegate/host/frame_recorder.h"

namespace alabaster::cli {

// These end the command after a message.
/// Checks that the checkpoints can be written, and that none would be lost.
void check_checkpoint_files(const RenderArguments& arguments, Console& console);
/// Checks them against the scene. `renders`: how many it describes.
void check_parts(const RenderArguments& arguments, const SceneSession& session, size_t renders, Console& console);

/// The files of all frames; none without --checkpoint.
std::vector<std::string> checkpoint_files(const RenderArguments& arguments);
/// Sets the options of the recording of a frame.
void set_checkpoint(const RenderArguments& arguments, const hd::RenderSettingsDescription& frame, Console& console,
                    hd::host::RecordOptions* options);
/// Takes the products from the scene, for a part that writes no picture, and returns their AOVs, which its sum will
/// need.
std::vector<std::string> take_part_aovs(const RenderArguments& arguments, SceneSession* session);

}  // namespace alabaster::cli
