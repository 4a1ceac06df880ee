#include "delegate/view/picture_panel.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace alabaster::view {
namespace {

constexpr float kClickSlack = 4;    // pixels that a click may move
constexpr float kDividerReach = 8;  // pixels
constexpr double kTurn = 2 * std::numbers::pi;

ImTextureID texture_id(unsigned texture) {
  return reinterpret_cast<ImTextureID>(static_cast<uintptr_t>(texture));
}

void write_over(ImDrawList* list, ImVec2 at, const char* text) {
  const ImVec2 size = ImGui::CalcTextSize(text);
  list->AddRectFilled({at.x - 4, at.y - 2}, {at.x + size.x + 4, at.y + size.y + 2}, IM_COL32(0, 0, 0, 150), 3);
  list->AddText(at, IM_COL32(235, 235, 235, 255), text);
}

}  // namespace

void PicturePanel::draw(const Textures& textures) {
  const ImVec2 room = ImGui::GetContentRegionAvail(), corner = ImGui::GetCursorScreenPos();
  const auto aspect = float(session_->aspect());
  ImVec2 size(std::max(room.x, 16.0f), std::max(room.y, 16.0f));
  if (size.x > size.y * aspect)
    size.x = std::max(1.0f, std::floor(size.y * aspect));
  else
    size.y = std::max(1.0f, std::floor(size.x / aspect));
  wanted_ = {int(size.x), int(size.y)};
  low_ = {std::floor(corner.x + (room.x - size.x) / 2), std::floor(corner.y + (room.y - size.y) / 2)};
  high_ = {low_.x + size.x, low_.y + size.y};
  ImGui::SetCursorScreenPos(low_);
  ImGui::InvisibleButton(
      "picture", size,
      ImGuiButtonFlags_MouseButtonLeft | ImGuiButtonFlags_MouseButtonMiddle | ImGuiButtonFlags_MouseButtonRight);
  handle_mouse();
  ImDrawList* const list = ImGui::GetWindowDrawList();
  if (textures.left != 0) list->AddImage(texture_id(textures.left), low_, high_);
  if (session_->compared() == Compare::side_by_side && textures.right != 0) draw_side_by_side(textures);
  if (picked_ && marked_) {
    const float x = low_.x + float(picked_->place.x) * size.x, y = low_.y + float(picked_->place.y) * size.y;
    list->AddCircle({x, y}, 5, IM_COL32(255, 170, 40, 255), 0, 2);
  }
}

// The denoised picture right of the divider.
void PicturePanel::draw_side_by_side(const Textures& textures) {
  ImDrawList* const list = ImGui::GetWindowDrawList();
  const float x = std::floor(low_.x + divider_ * (high_.x - low_.x));
  const float share = (x - low_.x) / (high_.x - low_.x);
  list->AddImage(texture_id(textures.right), {x, low_.y}, high_, {share, 0}, {1, 1});
  list->AddLine({x, low_.y}, {x, high_.y}, IM_COL32(255, 255, 255, 200), 1);
  list->AddTriangleFilled({x - 7, high_.y - 12}, {x, high_.y - 18}, {x, high_.y - 6}, IM_COL32(255, 255, 255, 220));
  list->AddTriangleFilled({x + 7, high_.y - 12}, {x, high_.y - 18}, {x, high_.y - 6}, IM_COL32(255, 255, 255, 220));
  const char* const kLeft = "as rendered";
  write_over(list, {x - ImGui::CalcTextSize(kLeft).x - 12, low_.y + 8}, kLeft);
  write_over(list, {x + 12, low_.y + 8}, "denoised");
}

hd::Vec2d PicturePanel::place(ImVec2 mouse) const {
  return {double(mouse.x - low_.x) / double(high_.x - low_.x), double(mouse.y - low_.y) / double(high_.y - low_.y)};
}

double PicturePanel::depth_near(const hd::Vec2d& at) {
  if (const auto depth = session_->depth_at(at.x, at.y)) return depth_ = *depth;
  if (depth_ > 0) return depth_;
  const auto middle = session_->depth_at(0.5, 0.5);
  return depth_ = middle.value_or(session_->scene_size());
}

void PicturePanel::handle_mouse() {
  const ImGuiIO& io = ImGui::GetIO();
  hovered_.reset();
  if (ImGui::IsItemHovered()) {
    hovered_ = place(io.MousePos);
    if (io.MouseWheel != 0) wheel(double(io.MouseWheel));
  }
  if (ImGui::IsItemActivated()) press();
  if (ImGui::IsItemActive()) {
    const float away = std::max(std::abs(io.MousePos.x - pressed_at_.x), std::abs(io.MousePos.y - pressed_at_.y));
    moved_ = moved_ || away > kClickSlack;
    if (moved_ && (io.MousePos.x != last_.x || io.MousePos.y != last_.y)) move();
    last_ = io.MousePos;
  }
  if (ImGui::IsItemDeactivated()) {
    if (!moved_ && drag_ == Drag::orbit) {
      const hd::Vec2d at = place(pressed_at_);
      picked_ = session_->pick(at.x, at.y);
      clicked_ = marked_ = true;
    }
    drag_ = Drag::none;
    moved_ = false;
  }
}

void PicturePanel::press() {
  const ImGuiIO& io = ImGui::GetIO();
  pressed_at_ = last_ = io.MousePos;
  moved_ = false;
  drag_ = Drag::orbit;
  if (io.MouseDown[ImGuiMouseButton_Middle] || io.KeyShift) drag_ = Drag::pan;
  if (io.MouseDown[ImGuiMouseButton_Right]) drag_ = Drag::zoom;
  const float divider = low_.x + divider_ * (high_.x - low_.x);
  if (session_->compared() == Compare::side_by_side && std::abs(io.MousePos.x - divider) < kDividerReach)
    drag_ = Drag::divider;
  pressed_camera_ = session_->camera();
  const hd::Vec2d at = place(io.MousePos);
  pivot_ = point_at(pressed_camera_.transform, session_->sight(), at.x, at.y, depth_near(at));
}

void PicturePanel::move() {
  const hd::Vec2d from = place(pressed_at_), to = place(ImGui::GetIO().MousePos), way = to - from;
  hd::CameraDescription camera = pressed_camera_;
  const Sight sight = session_->sight();
  const double scale = sight.orthographic ? 1 : depth_;
  switch (drag_) {
    case Drag::none:
      return;
    case Drag::divider:
      divider_ = std::clamp(float(to.x), 0.0f, 1.0f);
      return;
    case Drag::orbit:  // half a turn across the picture
      camera.transform = orbited(camera.transform, pivot_, -way.x * kTurn / 2, way.y * kTurn / 4);
      break;
    case Drag::pan:
      camera.transform = panned(camera.transform, -way.x * sight.width * scale, way.y * sight.height * scale);
      break;
    case Drag::zoom:
      zoom(&camera, pivot_, std::exp(2 * way.y));
      break;
  }
  marked_ = false;
  session_->set_camera(std::move(camera));
}

void PicturePanel::wheel(double steps) {
  const hd::Vec2d at = place(ImGui::GetIO().MousePos);
  hd::CameraDescription camera = session_->camera();
  const double factor = std::pow(0.9, steps), depth = depth_near(at);
  zoom(&camera, point_at(camera.transform, session_->sight(), at.x, at.y, depth), factor);
  depth_ = depth * factor;
  marked_ = false;
  session_->set_camera(std::move(camera));
}

}  // namespace alabaster::view
