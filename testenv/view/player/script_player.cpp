#include "testenv/view/player/script_player.h"

#include <GLFW/glfw3.h>
#include <imgui_impl_glfw.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <filesystem>

#include "delegate/cli/exit_codes.h"
#include "delegate/support/output_file.h"
#include "testenv/view/player/window_state.h"

namespace alabaster::view {
namespace {

constexpr int kRest = 4;           // pictures between two actions
constexpr int kDragSteps = 12;     // pictures that a drag takes
constexpr double kPatience = 60;   // seconds that a wait takes at most
constexpr double kWidgetWait = 5;  // seconds until a widget must have appeared

int button_of(const std::string& name) {
  if (name == "left") return ImGuiMouseButton_Left;
  if (name == "right") return ImGuiMouseButton_Right;
  return name == "middle" ? ImGuiMouseButton_Middle : -1;
}

ImVec2 on_picture(const PicturePanel& picture, double x, double y) {
  const hd::Vec2f at = picture.frame().cursor({x, y});
  return {at.x, at.y};
}

// ImGui 1.89 and later have keys as events, and their backend reads the modifiers from the real keyboard.
#if IMGUI_VERSION_NUM >= 18910
void hold_control(GLFWwindow* /*window*/, bool down) {
  ImGui::GetIO().AddKeyEvent(ImGuiMod_Ctrl, down);
}

void press_with_control(GLFWwindow* /*window*/, int letter, bool down) {
  ImGui::GetIO().AddKeyEvent(ImGuiKey(int(ImGuiKey_A) + letter - GLFW_KEY_A), down);
}
#else
void hold_control(GLFWwindow* window, bool down) {
  ImGui_ImplGlfw_KeyCallback(window, GLFW_KEY_LEFT_CONTROL, 0, down ? GLFW_PRESS : GLFW_RELEASE, 0);
}

void press_with_control(GLFWwindow* window, int letter, bool down) {
  ImGui_ImplGlfw_KeyCallback(window, letter, 0, down ? GLFW_PRESS : GLFW_RELEASE, GLFW_MOD_CONTROL);
}
#endif

// As PPM, the uppermost row first. The reason why it could not be written, or empty.
std::string save_screenshot(const std::string& file, GLFWwindow* window) {
  int width = 0, height = 0;
  glfwGetFramebufferSize(window, &width, &height);
  const size_t row = size_t(width) * 3;
  std::vector<uint8_t> pixels(row * size_t(height));
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, pixels.data());
  const std::string header = "P6\n" + std::to_string(width) + " " + std::to_string(height) + "\n255\n";
  std::vector<uint8_t> bytes(header.begin(), header.end());
  for (int y = height - 1; y >= 0; --y) {
    const auto first = pixels.begin() + std::ptrdiff_t(row * size_t(y));
    bytes.insert(bytes.end(), first, first + std::ptrdiff_t(row));
  }
  return hd::support::WriteOutputFile(file, bytes);
}

}  // namespace

void ScriptPlayer::fail(const ScriptAction& action, const std::string& text) {
  problem_ = "line " + std::to_string(action.line) + ": " + text;
}

void ScriptPlayer::click(ImVec2 at, bool control) {
  steps_.push_back({at, {}, {}, 0, control, "", 0});
  steps_.push_back({at, 0, {}, 0, control, "", 0});
  steps_.push_back({at, {}, 0, 0, control, "", 0});
}

void ScriptPlayer::drag(int button, ImVec2 from, ImVec2 to) {
  steps_.push_back({from, {}, {}, 0, false, "", 0});
  steps_.push_back({from, button, {}, 0, false, "", 0});
  for (int i = 1; i <= kDragSteps; ++i) {
    const float t = float(i) / kDragSteps;
    steps_.push_back({ImVec2(from.x + t * (to.x - from.x), from.y + t * (to.y - from.y)), {}, {}, 0, false, "", 0});
  }
  steps_.push_back({to, {}, button, 0, false, "", 0});
}

bool ScriptPlayer::is_over(const ScriptAction& wait, const Stage& stage) {
  if (begun_ < 0) begun_ = stage.begun;
  const std::string& what = wait.words[0];
  const double waited = stage.begun - begun_;
  if (what == "seconds") return waited >= wait.number(1);
  const bool counted = what == "samples";
  const bool whole = stage.settled && stage.status.state != hd::PassState::preparing;
  if (whole && stage.status.covered) {
    if (what == "covered" || (counted && stage.status.samples >= wait.number(1))) return true;
    if (what == "converged" && stage.status.state == hd::PassState::converged) return true;
  }
  const size_t longest = counted ? 2 : 1;
  if (waited > (wait.words.size() > longest ? wait.number(longest) : kPatience))
    fail(wait, "waited too long for " + what);
  return false;
}

// Widgets in menus and beyond the edge of a panel appear some pictures after what shows them.
bool ScriptPlayer::start_on_widget(const ScriptAction& action, const Stage& stage) {
  if (begun_ < 0) begun_ = stage.begun;
  const bool item = action.name == "choose" && !opened_.empty();
  const std::string name = item ? action.words[0] + "/" + action.words[1] : action.words[0];
  const Widgets::Place* const place = stage.widgets->find(name);
  if (!place || !place->visible) {
    stage.widgets->seek(name);
    if (stage.begun - begun_ > kWidgetWait) fail(action, "there is no widget '" + name + "' in sight");
    return false;
  }
  stage.widgets->seek("");
  begun_ = -1;
  const ImVec2 middle((place->low.x + place->high.x) / 2, (place->low.y + place->high.y) / 2);
  if (action.name == "slide") {
    // The grab of a slider is some pixels wide, and ends within it.
    const float share = std::clamp(float(action.number(1)), 0.0f, 1.0f), edge = 8 * unit();
    const float x = place->low.x + edge + share * (place->high.x - place->low.x - 2 * edge);
    drag(0, {middle.x, middle.y}, {x, middle.y});
    return true;
  }
  click(middle, action.name == "type");
  if (action.name == "type") {
    steps_.push_back({middle, {}, {}, 0, true, "", GLFW_KEY_A});
    steps_.push_back({middle, {}, {}, 0, false, action.words[1], 0});
    steps_.push_back({middle, {}, {}, 0, false, "", GLFW_KEY_ENTER});
  }
  if (action.name != "choose") return true;
  opened_ = item ? "" : action.words[0];
  return item;
}

// True once the action needs no more than the steps that it has left.
bool ScriptPlayer::start(const ScriptAction& a, const Stage& stage) {
  if (a.name == "wait") {
    if (!is_over(a, stage)) return false;
    begun_ = -1;
  } else if (a.name == "size") {
    glfwSetWindowSize(stage.window, int(a.number(0)), int(a.number(1)));
  } else if (a.name == "drag") {
    const int button = button_of(a.words[0]);
    if (button < 0) return fail(a, "'" + a.words[0] + "' is not left, middle or right"), false;
    drag(button, on_picture(*stage.picture, a.number(1), a.number(2)),
         on_picture(*stage.picture, a.number(3), a.number(4)));
  } else if (a.name == "click") {
    click(on_picture(*stage.picture, a.number(0), a.number(1)));
  } else if (a.name == "wheel") {
    const ImVec2 at = on_picture(*stage.picture, a.number(0), a.number(1));
    steps_.push_back({at, {}, {}, 0, false, "", 0});
    steps_.push_back({at, {}, {}, a.number(2), false, "", 0});
  } else if (a.name == "key") {
    const std::string& name = a.words[0];
    InputStep step;
    if (name == "space") step.text = " ", step.key = GLFW_KEY_SPACE;
    if (name == "escape") step.key = GLFW_KEY_ESCAPE;
    if (name == "enter") step.key = GLFW_KEY_ENTER;
    if (name.size() == 1) step.text = name, step.key = std::toupper(static_cast<unsigned char>(name[0]));
    if (step.key == 0) return fail(a, "there is no key '" + name + "'"), false;
    steps_.push_back(step);
  } else if (a.name == "copy") {
    std::error_code error;
    constexpr auto kReplace = std::filesystem::copy_options::overwrite_existing;
    if (!std::filesystem::copy_file(a.words[0], a.words[1], kReplace, error))
      return fail(a, a.words[0] + " was not copied: " + error.message()), false;
  } else if (a.name == "screenshot") {
    screenshot_ = a.words[0];
  } else if (a.name == "state") {
    state_ = true;
  } else if (a.name == "quit") {
    quit_ = true;
  } else {
    return start_on_widget(a, stage);
  }
  return true;
}

void ScriptPlayer::apply(const InputStep& step, const Stage& stage) {
  if (step.mouse) mouse_ = *step.mouse;
  if (step.press) held_[size_t(*step.press)] = true;
  if (step.release) held_[size_t(*step.release)] = false;
  if (step.wheel != 0) ImGui_ImplGlfw_ScrollCallback(stage.window, 0, step.wheel);
  press_key(step, stage, true);
  for (const char c : step.text) ImGui_ImplGlfw_CharCallback(stage.window, static_cast<unsigned char>(c));
}

void ScriptPlayer::press_key(const InputStep& step, const Stage& stage, bool down) {
  if (step.key == 0) return;
  if (step.control) return press_with_control(stage.window, step.key, down);
  ImGui_ImplGlfw_KeyCallback(stage.window, step.key, 0, down ? GLFW_PRESS : GLFW_RELEASE, 0);
}

void ScriptPlayer::feed(const Stage& stage) {
  ImGuiIO& io = ImGui::GetIO();
  press_key(std::exchange(last_, {}), stage, false);
  hold_control(stage.window, !steps_.empty() && steps_.front().control);
  if (!steps_.empty()) {
    apply(steps_.front(), stage);
    last_ = std::move(steps_.front());
    steps_.pop_front();
    if (steps_.empty()) rest_ = kRest;
  } else if (rest_ > 0) {
    --rest_;
  } else if (problem_.empty() && next_ < script_.actions.size()) {
    if (start(script_.actions[next_], stage)) ++next_, rest_ = kRest;
  }
  io.MousePos = mouse_;
  for (size_t i = 0; i < held_.size(); ++i) io.MouseDown[i] = held_[i];
}

int ScriptPlayer::see(const Stage& stage) {
  const double now = glfwGetTime();
  times_.add(now, 1e3 * (now - stage.begun));
  if (const std::string file = std::exchange(screenshot_, {}); !file.empty())
    if (const std::string problem = save_screenshot(file, stage.window); !problem.empty()) {
      std::fprintf(stderr, "error: %s: the screenshot could not be written: %s\n", file.c_str(), problem.c_str());
      return cli::kOutput;
    }
  if (std::exchange(state_, false)) {
    std::puts(window_state(stage, &times_).c_str());
    std::fflush(stdout);
  }
  if (!problem_.empty()) {
    std::fprintf(stderr, "error: script: %s\n", problem_.c_str());
    return cli::kRender;
  }
  return quit_ ? int(cli::kDone) : -1;
}

}  // namespace alabaster::view
