// Plays a script: each picture of the window gets a little of the mouse and the keyboard, as from a user. Internal to
// this room.
#pragma once

#include <array>
#include <deque>
#include <optional>

#include "delegate/view/picture_panel.h"
#include "delegate/view/script.h"

struct GLFWwindow;

namespace alabaster::view {

/// The share of an action that one picture of the window gets.
struct InputStep {
  std::optional<ImVec2> mouse;
  std::optional<int> press, release;  // a button
  double wheel = 0;
  bool control = false;  // the key is held
  std::string text;      // typed
  int key = 0;           // of GLFW, pressed and released; 0: none
};

/// The window as a script sees it.
struct Stage {
  GLFWwindow* window = nullptr;
  const PicturePanel* picture = nullptr;
  Widgets* widgets = nullptr;
  ViewStatus status;
  bool settled = false;  // the picture that is shown is of the size and of the pixels that it should be
  double seconds = 0;    // now
};

class ScriptPlayer {
 public:
  explicit ScriptPlayer(Script script) : script_(std::move(script)) {}

  /// Wishes for the window, to be met once it has been drawn.
  struct Wish {
    std::string screenshot;  // file; empty: none
    bool state = false, quit = false;
  };
  /// Feeds the events of one picture; between the new frames of ImGui's backend and of ImGui.
  void feed(const Stage& stage);
  Wish take_wish() { return std::exchange(wish_, {}); }
  /// Why the script cannot go on, with its line; empty if it can.
  const std::string& problem() const { return problem_; }

 private:
  bool start(const ScriptAction& action, const Stage& stage);
  bool start_on_widget(const ScriptAction& action, const Stage& stage);
  bool is_over(const ScriptAction& wait, const Stage& stage);
  void apply(const InputStep& step, const Stage& stage);
  void press_key(const InputStep& step, const Stage& stage, bool down);
  void drag(int button, ImVec2 from, ImVec2 to);
  void click(ImVec2 at, bool control = false);
  void fail(const ScriptAction& action, const std::string& text);

  Script script_;
  size_t next_ = 0;
  std::deque<InputStep> steps_;
  InputStep last_;     // whose key is down
  double begun_ = -1;  // of the action that waits
  int rest_ = 0;       // pictures until the next action
  ImVec2 mouse_{-1, -1};
  std::array<bool, 3> held_{};
  std::string opened_;  // the menu whose item comes next
  Wish wish_;
  std::string problem_;
};

}  // namespace alabaster::view
