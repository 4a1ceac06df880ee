// The command that a render proposes at its end.
#pragma once

#include <string>

#include "delegate/cli/commands.h"

namespace alabaster::cli {

/// The result of a render, as far as a next command depends on it.
struct RenderFindings {
  bool degraded = false;    // rendered without all of its scene
  bool warned = false;      // there were warnings of the scene
  bool has_camera = false;  // of its own
  bool has_light = false;
  bool denoised = false;
  double noise = -1;  // relative RMSE before denoising; negative: not known
};

/// "alabaster ...  # purpose": the one command that improves the picture most. Empty if it would hold a word that
/// cannot be copied.
std::string next_command(const RenderArguments& arguments, const RenderFindings& findings);

}  // namespace alabaster::cli
