// The window: GLFW, OpenGL and the loop. Internal to this room.
#pragma once

#include "delegate/view/messages.h"
#include "delegate/view/script.h"
#include "delegate/view/view_session.h"

namespace alabaster::view {

struct WindowOptions {
  hd::Vec2i size{1440, 860};
  std::string title, scene_file;
  Script script;  // without actions: the user acts
};

/// Opens the window and returns the program's exit code when it is closed. Errors go to `console`.
int run_window(ViewSession* session, Messages* messages, const WindowOptions& options, cli::Console* console);

}  // namespace alabaster::view
