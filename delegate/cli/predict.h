// alabaster info --predict E: predicts the cost of rendering a loaded scene to an error.
#pragma once

#include <nlohmann/json.hpp>

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

/// Renders a few small pictures of `session`, which has been started and synced, for about three seconds. Adds
/// "prediction" to a listing: the predicted samples, time and memory to reach `target` with its render settings.
/// Returns an exit code. A signal ends it where signals are caught (interrupt.h).
int predict(SceneSession* session, Console* console, const Preparation& spent, double target,
            nlohmann::ordered_json* scene);

void print_prediction(const nlohmann::ordered_json& prediction);

}  // namespace alabaster::cli
