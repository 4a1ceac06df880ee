// alabaster info --predict E: predicts the cost of rendering a loaded scene to an error.
#pragma once

#include "delegate/cli/scene_session.h"

namespace alabaster::cli {

/// Wall and CPU seconds.
struct Seconds {
  double wall = 0, cpu = 0;
};

/// Time spent on the scene before its first sample.
struct Preparation {
  Seconds load, sync;
};

/// Renders a few small pictures of `session`, which has been started and synced, for about three seconds, and prints
/// the predicted samples, time and memory to reach `target` with its render settings. Returns an exit code. A signal
/// ends it where signals are caught (interrupt.h).
int print_prediction(SceneSession* session, Console* console, const Preparation& spent, double target);

}  // namespace alabaster::cli
