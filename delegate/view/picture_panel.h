// The picture in the window: drawing it, and the mouse over it. Internal to this room.
#pragma once

#include <utility>

#include "delegate/view/picture_frame.h"
#include "delegate/view/view_session.h"
#include "delegate/view/widgets.h"

namespace alabaster::view {

/// Textures of OpenGL with the pixels that are shown; 0: none yet.
struct Textures {
  unsigned left = 0, right = 0;
};

class PicturePanel {
 public:
  explicit PicturePanel(ViewSession* session) : session_(session) {}

  /// Fills the current ImGui window. The picture keeps the shape of the scene's frame.
  void draw(const Textures& textures, const ViewStatus& status);
  /// A tool that left drags use on a light, and the light to show; none and empty: none.
  void use(LightTool tool, const hd::Path& light) { tool_ = tool, light_ = light; }
  const PictureFrame& frame() const { return frame_; }

  const std::optional<Picked>& picked() const { return picked_; }
  /// Once after each click; the pick may have found nothing.
  bool take_click() { return std::exchange(clicked_, false); }
  /// The place under the mouse, from 0 to 1 with y down; empty if it is elsewhere.
  std::optional<hd::Vec2d> hovered() const { return hovered_; }

 private:
  enum class Drag { none, orbit, pan, zoom, divider, light };
  void draw_divided(const Textures& textures, const ViewStatus& status);
  void draw_light();
  void handle_mouse();
  void press();
  void move();
  void press_light();
  void move_light(const hd::Vec2d& to);
  void wheel(double steps);
  hd::Vec2d place(ImVec2 mouse) const;
  float divider() const;
  double depth_near(const hd::Vec2d& place);

  ViewSession* session_;
  PictureFrame frame_;
  Drag drag_ = Drag::none;
  bool moved_ = false, clicked_ = false;
  bool marked_ = false;  // the picked place is where it was
  ImVec2 pressed_at_{0, 0}, last_{0, 0};
  hd::CameraDescription pressed_camera_;
  hd::Vec3d pivot_{0, 0, 0};
  double depth_ = 0;  // of the last pivot; 0: none yet
  LightTool tool_ = LightTool::none;
  hd::Path light_;              // empty: none is shown
  hd::Matrix4d pressed_light_;  // where it was
  double light_distance_ = 1;   // of the light to the point that was pressed
  std::optional<Picked> picked_;
  std::optional<hd::Vec2d> hovered_;
};

}  // namespace alabaster::view
