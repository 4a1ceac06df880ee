// The state of a window as a line of JSON, for scripts. Internal to this room.
#pragma once

#include "delegate/view/frame_times.h"
#include "delegate/view/messages.h"
#include "delegate/view/picture_frame.h"
#include "delegate/view/view_session.h"

namespace alabaster::view {

std::string window_state(const ViewSession& session, const ViewStatus& status, const std::optional<Picked>& picked,
                         const Messages& messages, const ScreenScale& scale, FrameTimes* times);

}  // namespace alabaster::view
