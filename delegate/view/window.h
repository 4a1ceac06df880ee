// The window: GLFW, OpenGL and the loop, and what may act in the place of its user.
#pragma once

#include "delegate/view/messages.h"
#include "delegate/view/picture_panel.h"
#include "delegate/view/scene_reload.h"

struct GLFWwindow;

namespace alabaster::view {

/// The window as its driver sees it.
struct Stage {
  GLFWwindow* window = nullptr;
  const PicturePanel* picture = nullptr;
  Widgets* widgets = nullptr;
  const ViewSession* session = nullptr;
  const SceneReload* reload = nullptr;
  const Messages* messages = nullptr;
  ViewStatus status;
  bool settled = false;  // the picture that is shown is of the size and of the pixels that it should be
  double begun = 0;      // GLFW's time at which this picture of the window was begun
};

/// Acts in the place of a user: testenv/view/player has one. In the window's thread.
class WindowDriver {
 public:
  virtual ~WindowDriver() = default;
  /// Adds events of mouse and keyboard; between the new frames of ImGui's backend and of ImGui.
  virtual void feed(const Stage& stage) = 0;
  /// Sees the picture of the window before it is shown. The program's exit code, or below 0: it goes on.
  virtual int see(const Stage& stage) = 0;
};

struct WindowOptions {
  hd::Vec2i size{1440, 860};
  std::string title, scene_file;
  WindowDriver* driver = nullptr;  // null: the user acts
};

/// Opens the window and returns the program's exit code when it is closed. Errors go to `console`.
int run_window(ViewSession* session, SceneReload* reload, Messages* messages, const WindowOptions& options,
               cli::Console* console);

/// Pixels of the framebuffer, units of the window and the size that the desktop asks for.
ScreenScale scale_of(GLFWwindow* window);

/// The program alabaster-view. Its exit code; errors are printed.
int run_program(int argc, char** argv, WindowDriver* driver = nullptr);

}  // namespace alabaster::view
