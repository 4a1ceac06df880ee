#include "delegate/view/window.h"

#include <GLFW/glfw3.h>
#include <imgui_impl_glfw.h>
#include <imgui_impl_opengl3.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <thread>

#include "delegate/cli/exit_codes.h"
#include "delegate/view/panels.h"

namespace alabaster::view {
namespace {

constexpr double kFrame = 1.0 / 60;   // seconds
constexpr double kRest = 0.1;         // seconds between frames while nothing moves
constexpr int kQuietFrames = 20;      // without new pixels, before it rests
constexpr double kResizeRest = 0.15;  // seconds that a size must last before it is rendered
constexpr const char* kFonts[] = {"/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf",
                                  "/usr/share/fonts/TTF/DejaVuSans.ttf"};
constexpr float kFontSize = 15, kSideWidth = 30;         // the width in letters
constexpr float kLeastWidth = 1000, kLeastHeight = 540;  // pixels of a plain screen that toolbar and panels need

std::string g_glfw_error;  // GLFW reports through a function without an argument of ours

/// GLFW and ImGui, ended in the right order.
class Screen {
 public:
  ~Screen() {
    if (begun_) {
      ImGui_ImplOpenGL3_Shutdown();
      ImGui_ImplGlfw_Shutdown();
      ImGui::DestroyContext();
    }
    if (window) glfwDestroyWindow(window);
    glfwTerminate();
  }

  bool open(const WindowOptions& options) {
    glfwSetErrorCallback([](int, const char* text) { g_glfw_error = text; });
    if (glfwInit() != GLFW_TRUE) return false;
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 0);
    glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
    window = glfwCreateWindow(options.size.x, options.size.y, options.title.c_str(), nullptr, nullptr);
    if (!window) return false;
    glfwMakeContextCurrent(window);
    glfwSwapInterval(1);
    IMGUI_CHECKVERSION();
    ImGui::CreateContext();
    ImGui::GetIO().IniFilename = nullptr;  // the layout is fixed, and no file of it is left behind
    begun_ = ImGui_ImplGlfw_InitForOpenGL(window, true) && ImGui_ImplOpenGL3_Init("#version 130");
    if (begun_) follow_scale();
    return begun_;
  }

  /// Letters and widgets get the size that the screen asks for which the window is on.
  void follow_scale() {
    const ScreenScale now = scale_of(window);
    if (now == scale_) return;
    scale_ = now;
    ImGuiIO& io = ImGui::GetIO();
    ImGui_ImplOpenGL3_DestroyFontsTexture();
    io.Fonts->Clear();
    load_font(now);
    io.FontGlobalScale = 1 / now.density;
    set_style(now.units(1));
    glfwSetWindowSizeLimits(window, int(now.units(kLeastWidth)), int(now.units(kLeastHeight)), GLFW_DONT_CARE,
                            GLFW_DONT_CARE);
  }

  GLFWwindow* window = nullptr;

 private:
  static void load_font(const ScreenScale& scale) {
    for (const char* file : kFonts)
      if (std::filesystem::exists(file) &&
          ImGui::GetIO().Fonts->AddFontFromFileTTF(file, std::floor(scale.pixels(kFontSize))))
        return;
    ImFontConfig plain;  // ImGui's own letters have 13 pixels
    plain.SizePixels = std::floor(scale.pixels(13));
    ImGui::GetIO().Fonts->AddFontDefault(&plain);
  }

  // `scale`: units of the window for a pixel of a plain screen.
  static void set_style(float scale) {
    ImGuiStyle style;
    ImGui::StyleColorsDark(&style);
    style.WindowRounding = 0;
    style.FrameRounding = 3;
    style.GrabRounding = 3;
    style.WindowBorderSize = 0;
    style.Colors[ImGuiCol_WindowBg] = ImVec4(0.11f, 0.11f, 0.12f, 1);
    // Numbers stand over the grabs of their sliders.
    style.Colors[ImGuiCol_SliderGrab] = ImVec4(0.30f, 0.47f, 0.70f, 0.55f);
    style.Colors[ImGuiCol_SliderGrabActive] = ImVec4(0.36f, 0.56f, 0.85f, 0.75f);
    style.ScaleAllSizes(scale);
    ImGui::GetStyle() = style;
  }

  ScreenScale scale_{0, 0};  // of the letters and widgets
  bool begun_ = false;
};

/// A texture that shows a picture.
class PictureTexture {
 public:
  void show(const Picture& picture) {
    if (id_ == 0) glGenTextures(1, &id_);
    glBindTexture(GL_TEXTURE_2D, id_);
    for (const int filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
      glTexParameteri(GL_TEXTURE_2D, GLenum(filter), GL_LINEAR);
    for (const int wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
      glTexParameteri(GL_TEXTURE_2D, GLenum(wrap), GL_CLAMP_TO_EDGE);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    if (picture.size == size_)
      glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, size_.x, size_.y, GL_RGBA, GL_UNSIGNED_BYTE, picture.rgba.data());
    else
      glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB8, picture.size.x, picture.size.y, 0, GL_RGBA, GL_UNSIGNED_BYTE,
                   picture.rgba.data());
    size_ = picture.size;
  }
  unsigned id() const { return id_; }
  hd::Vec2i size() const { return size_; }

 private:
  unsigned id_ = 0;
  hd::Vec2i size_{0, 0};
};

class Window {
 public:
  Window(ViewSession* session, SceneReload* reload, Messages* messages, const WindowOptions& options)
      : session_(session),
        reload_(reload),
        messages_(messages),
        driver_(options.driver),
        panels_(session, reload, &widgets_, messages, options.scene_file),
        picture_(session) {}

  int run(Screen* screen) {
    window_ = screen->window;
    while (!glfwWindowShouldClose(window_)) {
      const double begun = glfwGetTime();
      glfwPollEvents();
      int width = 0, height = 0;
      glfwGetFramebufferSize(window_, &width, &height);
      if (width < 1 || height < 1) {  // iconified
        glfwWaitEventsTimeout(0.1);
        continue;
      }
      screen->follow_scale();
      follow_files();
      session_->update();
      status_ = session_->status();
      heed_failure();
      bring_pictures();
      draw(width, height, begun);
      if (const int code = driver_ ? driver_->see(stage(begun)) : -1; code >= 0) return code;
      glfwSwapBuffers(window_);
      const double left = kFrame - (glfwGetTime() - begun);
      if (rests())
        glfwWaitEventsTimeout(kRest);
      else if (left > 0.001)
        std::this_thread::sleep_for(std::chrono::duration<double>(left));
    }
    return cli::kDone;
  }

 private:
  // Without the library of the denoiser, or where it fails, the picture as rendered is shown.
  void heed_failure() {
    if (status_.state != hd::PassState::failed || session_->compared() == Compare::rendered) return;
    session_->compare(Compare::rendered);
  }

  void follow_files() {
    const bool was_offered = reload_->has_changed();
    reload_->look();
    if (reload_->has_changed() && !was_offered) panels_.tell("A file of the scene has changed: Reload, or key L.");
    std::unique_ptr<cli::SceneSession> loaded = reload_->take();
    if (!loaded) return;
    fetcher_.forget();
    session_->reload(std::move(loaded));
    panels_.tell("The scene was loaded again.");
  }

  void bring_pictures() {
    fetcher_.fetch(session_->left(), session_->right());
    for (int side = 0; side < 2; ++side)
      if (fetcher_.take(side == 1, &pictures_[side])) textures_[side].show(pictures_[side]), quiet_ = 0;
    ++quiet_;
  }

  void draw(int width, int height, double begun) {
    ImGui_ImplOpenGL3_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    if (driver_) driver_->feed(stage(begun));
    ImGui::NewFrame();
    widgets_.begin_frame();
    panels_.handle_keys();
    draw_layout();
    if (picture_.take_click()) panels_.show(picture_.picked());
    follow_size();
    ImGui::Render();
    glViewport(0, 0, width, height);
    glClearColor(0, 0, 0, 1);
    glClear(GL_COLOR_BUFFER_BIT);
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
  }

  void draw_layout() {
    const ImVec2 size = ImGui::GetIO().DisplaySize;
    const float bar = ImGui::GetFrameHeight() + 2 * ImGui::GetStyle().WindowPadding.y;
    const float side = panels_.side_is_shown() ? std::min(kSideWidth * ImGui::GetFontSize(), size.x / 2) : 0;
    begin("toolbar", {0, 0}, {size.x, bar});
    panels_.draw_toolbar();
    ImGui::End();
    ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, ImVec2(0, 0));
    ImGui::PushStyleColor(ImGuiCol_WindowBg, ImVec4(0.06f, 0.06f, 0.06f, 1));
    begin("picture", {0, bar}, {size.x - side, size.y - 2 * bar});
    ImGui::PopStyleVar();
    picture_.draw({textures_[0].id(), textures_[1].id()}, status_);
    ImGui::End();
    ImGui::PopStyleColor();
    if (side > 0) {
      begin("side", {size.x - side, bar}, {side, size.y - 2 * bar});
      panels_.draw_side();
      ImGui::End();
    }
    picture_.use(panels_.light_tool(), panels_.shown_light());
    begin("status", {0, size.y - bar}, {size.x, bar});
    panels_.draw_status(status_, picture_.hovered());
    ImGui::End();
  }

  static void begin(const char* name, ImVec2 at, ImVec2 size) {
    ImGui::SetNextWindowPos(at);
    ImGui::SetNextWindowSize(size);
    ImGui::Begin(name, nullptr,
                 ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings |
                     ImGuiWindowFlags_NoBringToFrontOnFocus | ImGuiWindowFlags_NoScrollWithMouse);
  }

  // A window that is being resized renders once it rests.
  void follow_size() {
    const hd::Vec2i size = picture_.frame().pixels(panels_.reduction());
    if (!(size == asked_size_)) asked_size_ = size, asked_at_ = glfwGetTime();
    if (!(size == session_->size()) && (glfwGetTime() - asked_at_ > kResizeRest)) session_->set_size(size);
  }

  // The newest pixels are on the screen, or are renewed faster than anybody waits.
  bool settled() const {
    const PictureTexture& live = textures_[session_->kept_look() ? 1 : 0];
    return asked_size_ == session_->size() && live.size() == session_->size() && quiet_ < 100000 &&
           !reload_->is_busy() && (status_.state != hd::PassState::converged || (quiet_ > 5 && !fetcher_.busy()));
  }

  // Nothing moves until the user does something: no need to draw sixty times a second.
  bool rests() const {
    const bool over =
        session_->paused() || status_.state == hd::PassState::converged || status_.state == hd::PassState::failed;
    return over && !driver_ && !reload_->is_busy() && quiet_ > kQuietFrames && !fetcher_.busy() &&
           !ImGui::IsAnyItemActive();
  }

  Stage stage(double begun) {
    return {window_, &picture_, &widgets_, session_, reload_, messages_, status_, settled(), begun};
  }

  ViewSession* session_;
  SceneReload* reload_;
  Messages* messages_;
  WindowDriver* const driver_;
  Widgets widgets_;
  Panels panels_;
  PicturePanel picture_;
  PictureFetcher fetcher_;
  Picture pictures_[2];
  PictureTexture textures_[2];
  GLFWwindow* window_ = nullptr;
  ViewStatus status_;
  hd::Vec2i asked_size_{0, 0};
  double asked_at_ = 0;
  int quiet_ = 0;  // pictures of the window since the last new pixels
};

}  // namespace

ScreenScale scale_of(GLFWwindow* window) {
  ScreenScale scale;
  int width = 0, height = 0, pixels = 0;
  glfwGetWindowSize(window, &width, &height);
  glfwGetFramebufferSize(window, &pixels, &height);
  glfwGetWindowContentScale(window, &scale.content, nullptr);
  if (!(scale.content > 0)) scale.content = 1;
  if (width > 0 && pixels > 0) scale.density = float(pixels) / float(width);
  return scale;
}

int run_window(ViewSession* session, SceneReload* reload, Messages* messages, const WindowOptions& options,
               cli::Console* console) {
  Screen screen;
  if (!screen.open(options)) {
    console->error("window", "It could not be opened: " + (g_glfw_error.empty() ? "no OpenGL 3" : g_glfw_error) +
                                 ". A display with OpenGL 3 is needed: run it in a desktop session, or with xvfb-run.");
    return cli::kRender;
  }
  return Window(session, reload, messages, options).run(&screen);
}

}  // namespace alabaster::view
