// alabaster info --predict E: what rendering a loaded scene to an error will take.
#pragma once

#include <optional>
#include <string>

#include "delegate/cli/scene_session.h"

namespace alabaster::cli {

/// Wall and CPU seconds.
struct Seconds {
  double wall = 0, cpu = 0;
};

/// A relative RMSE: above 0, at most 1. Empty if malformed.
std::optional<double> parse_target_error(const std::string& text);

/// What has been spent on the scene before its first sample.
struct Preparation {
  Seconds load, sync;
};

/// Renders a few small pictures of `session`, which has been started and synced, for about three seconds, and prints
/// what reaching `target` with its render settings takes. An exit code. Where signals are caught (interrupt.h) one ends
/// it.
int print_prediction(SceneSession* session, Console* console, const Preparation& spent, double target);

}  // namespace alabaster::cli
