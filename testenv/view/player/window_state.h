// The state of a window as a line of JSON, for scripts.
#pragma once

#include "delegate/view/window.h"
#include "testenv/view/player/frame_times.h"

namespace alabaster::view {

std::string window_state(const Stage& stage, FrameTimes* times);

}  // namespace alabaster::view
