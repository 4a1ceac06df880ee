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
  void draw(const Textures& textures);
  const PictureFrame& frame() const { return frame_; }

  const std::optional<Picked>& picked() const { return picked_; }
  /// Once after each click; the pick may have found nothing.
  bool take_click() { return std::exchange(clicked_, false); }
  /// The place under the mouse, from 0 to 1 with y down; empty if it is elsewhere.
  std::optional<hd::Vec2d> hovered() const { return hovered_; }

 private:
  enum class Drag { none, orbit, pan, zoom, divider };
  void draw_side_by_side(const Textures& textures);
  void handle_mouse();
  void press();
  void move();
  void wheel(double steps);
  hd::Vec2d place(ImVec2 mouse) const;
  float divider() const;
  double depth_near(const hd::Vec2d& place);

  ViewSession* session_;
  PictureFrame frame_;
  float divider_ = 0.5f;  // share of the picture
  Drag drag_ = Drag::none;
  bool moved_ = false, clicked_ = false;
  bool marked_ = false;  // the picked place is where it was
  ImVec2 pressed_at_{0, 0}, last_{0, 0};
  hd::CameraDescription pressed_camera_;
  hd::Vec3d pivot_{0, 0, 0};
  double depth_ = 0;  // of the last pivot; 0: none yet
  std::optional<Picked> picked_;
  std::optional<hd::Vec2d> hovered_;
};

}  // namespace alabaster::view
