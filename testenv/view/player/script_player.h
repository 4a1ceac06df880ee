// Plays a script: each picture of the window gets a little of the mouse and the keyboard, as from a user.
#pragma once

#include <array>
#include <deque>
#include <optional>

#include "delegate/view/window.h"
#include "testenv/view/player/frame_times.h"
#include "testenv/view/player/script.h"

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

class ScriptPlayer final : public WindowDriver {
 public:
  explicit ScriptPlayer(Script script) : script_(std::move(script)) {}

  void feed(const Stage& stage) override;
  /// Prints states, writes screenshots, and ends the program at `quit` and where the script cannot go on.
  int see(const Stage& stage) override;

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
  FrameTimes times_;
  std::string screenshot_;  // file that the next picture is written to; empty: none
  bool state_ = false, quit_ = false;
  std::string problem_;  // why the script cannot go on, with its line
};

}  // namespace alabaster::view
