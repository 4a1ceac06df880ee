#include "delegate/view/picture_panel.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

namespace alabaster::view {
namespace {

constexpr float kClickSlack = 4;    // units that a click may move
constexpr float kDividerReach = 8;  // units
constexpr double kTurn = 2 * std::numbers::pi;

ImTextureID texture_id(unsigned texture) {
  return std::bit_cast<ImTextureID>(static_cast<uintptr_t>(texture));
}

ImVec2 point(const hd::Vec2f& p) {
  return {p.x, p.y};
}

void write_over(ImDrawList* list, ImVec2 at, const char* text) {
  const ImVec2 size = ImGui::CalcTextSize(text);
  const float u = unit();
  list->AddRectFilled({at.x - 4 * u, at.y - 2 * u}, {at.x + size.x + 4 * u, at.y + size.y + 2 * u},
                      IM_COL32(0, 0, 0, 150), 3 * u);
  list->AddText(at, IM_COL32(235, 235, 235, 255), text);
}

std::string look_text(const char* name, const std::string& aov, bool is_denoised, uint32_t samples, double noise) {
  std::string text = name + std::string("   ") + (aov == "color" ? "" : aov + ", ") + std::to_string(samples) +
                     (samples == 1 ? " sample" : " samples");
  if (noise >= 0) text += ", noise " + percent(noise);
  return is_denoised ? text + ", denoised" : text;
}

}  // namespace

void PicturePanel::draw(const Textures& textures, const ViewStatus& status) {
  const ImVec2 room = ImGui::GetContentRegionAvail(), corner = ImGui::GetCursorScreenPos();
  const float density = ImGui::GetIO().DisplayFramebufferScale.x;
  frame_ = PictureFrame::fit({corner.x, corner.y}, {room.x, room.y}, session_->aspect(), density > 0 ? density : 1);
  const ImVec2 low = point(frame_.low()), high = point(frame_.high());
  ImGui::SetCursorScreenPos(low);
  ImGui::InvisibleButton(
      "picture", {high.x - low.x, high.y - low.y},
      ImGuiButtonFlags_MouseButtonLeft | ImGuiButtonFlags_MouseButtonMiddle | ImGuiButtonFlags_MouseButtonRight);
  handle_mouse();
  ImDrawList* const list = ImGui::GetWindowDrawList();
  if (textures.left != 0) list->AddImage(texture_id(textures.left), low, high);
  if (session_->is_divided() && textures.right != 0) draw_divided(textures, status);
  if (!light_.empty()) draw_light();
  if (picked_ && marked_) {
    list->AddCircle(point(frame_.cursor(picked_->place)), 5 * unit(), IM_COL32(255, 170, 40, 255), 0, 2 * unit());
  }
}

// The other picture right of the divider.
void PicturePanel::draw_divided(const Textures& textures, const ViewStatus& status) {
  ImDrawList* const list = ImGui::GetWindowDrawList();
  const ImVec2 low = point(frame_.low()), high = point(frame_.high());
  const float x = std::floor(divider()), u = unit();
  const auto share = float(frame_.place({x, 0}).x);
  list->AddImage(texture_id(textures.right), {x, low.y}, high, {share, 0}, {1, 1});
  list->AddLine({x, low.y}, {x, high.y}, IM_COL32(255, 255, 255, 200), u);
  for (const float side : {-7 * u, 7 * u})
    list->AddTriangleFilled({x + side, high.y - 12 * u}, {x, high.y - 18 * u}, {x, high.y - 6 * u},
                            IM_COL32(255, 255, 255, 220));
  std::string left = "as rendered", right = "denoised";
  if (const KeptLook* const kept = session_->kept_look()) {
    left = look_text("A", kept->aov, kept->is_denoised, kept->samples, kept->noise);
    if (!session_->is_kept_framing()) left += ", of another view";
    const bool is_denoised = session_->compared() != Compare::rendered && !status.denoiser.empty();
    const KeptLook* const known = session_->stand_in();
    right = known ? look_text("B", known->aov, known->is_denoised, known->samples, known->noise)
                  : look_text("B", session_->aov(), is_denoised, status.samples, status.noise);
  }
  write_over(list, {x - ImGui::CalcTextSize(left.c_str()).x - 12 * u, low.y + 8 * u}, left.c_str());
  write_over(list, {x + 12 * u, low.y + 8 * u}, right.c_str());
}

// Its place and where it shines, where it has these and the picture shows them; and what the mouse does.
void PicturePanel::draw_light() {
  ImDrawList* const list = ImGui::GetWindowDrawList();
  const float u = unit();
  if (tool_ != LightTool::none) {
    const std::string hint = std::string(tool_ == LightTool::move  ? "Drag: moves "
                                         : tool_ == LightTool::aim ? "Click or drag: aims "
                                                                   : "Click or drag: highlight of ") +
                             light_.str();
    write_over(list, {frame_.low().x + 12 * u, frame_.high().y - 28 * u}, hint.c_str());
  }
  const std::string type = session_->edits().light_type(light_);
  if (!can_use(LightTool::move, type)) return;
  const hd::Matrix4d light = session_->edits().transform(light_), &camera = session_->camera().transform;
  const hd::Vec3d from = light.translation(), way(-light[2][0], -light[2][1], -light[2][2]);
  const auto at = place_of(camera, session_->sight(), from);
  if (!at || at->x < 0 || at->x > 1 || at->y < 0 || at->y > 1) return;
  const ImVec2 middle = point(frame_.cursor(*at));
  constexpr ImU32 kYellow = IM_COL32(255, 220, 90, 255);
  const double length = 0.15 * (camera.translation() - from).length();
  const auto end = place_of(camera, session_->sight(), from + way.normalized() * length);
  if (end && type != "sphereLight") list->AddLine(middle, point(frame_.cursor(*end)), kYellow, 2 * u);
  list->AddCircleFilled(middle, 5 * u, kYellow);
  list->AddCircle(middle, 9 * u, kYellow, 0, 1.5f * u);
}

hd::Vec2d PicturePanel::place(ImVec2 mouse) const {
  return frame_.place({mouse.x, mouse.y});
}

float PicturePanel::divider() const {
  return frame_.low().x + float(session_->divider()) * (frame_.high().x - frame_.low().x);
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
    moved_ = moved_ || away > kClickSlack * unit();
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
  if (tool_ != LightTool::none && drag_ == Drag::orbit) drag_ = Drag::light;
  if (session_->is_divided() && std::abs(io.MousePos.x - divider()) < kDividerReach * unit()) drag_ = Drag::divider;
  pressed_camera_ = session_->camera();
  const hd::Vec2d at = place(io.MousePos);
  pivot_ = point_at(pressed_camera_.transform, session_->sight(), at.x, at.y, depth_near(at));
  if (drag_ == Drag::light) press_light();
}

// The picture of depths and normals that was pressed serves the whole drag: each edit begins another one.
void PicturePanel::press_light() {
  pressed_light_ = session_->edits().transform(light_);
  light_distance_ = (pressed_light_.translation() - pivot_).length();
  if (tool_ == LightTool::move) return;
  if (session_->read_surface())
    move_light(place(pressed_at_));
  else
    drag_ = Drag::none;
}

void PicturePanel::move_light(const hd::Vec2d& to) {
  hd::Matrix4d light = pressed_light_;
  if (tool_ == LightTool::move) {
    // It stays under the mouse if it is in sight.
    const hd::Matrix4d& camera = pressed_camera_.transform;
    const hd::Vec3d back(camera[2][0], camera[2][1], camera[2][2]);
    const double own = (camera.translation() - light.translation()).dot(back.normalized());
    const double depth = own > 0 ? own : depth_;
    const hd::Vec2d from = place(pressed_at_);
    const Sight sight = session_->sight();
    light = light * hd::Matrix4d().setTranslation(point_at(camera, sight, to.x, to.y, depth) -
                                                  point_at(camera, sight, from.x, from.y, depth));
  } else {
    const auto surface = session_->surface_at(to.x, to.y);
    if (!surface) return;
    light = tool_ == LightTool::aim
                ? aimed(light, surface->point, session_->up())
                : mirrored(light, *surface, session_->to_eye(surface->point), light_distance_, session_->up());
  }
  session_->edit(light_, [&] { return session_->edits().place(light_, light); });
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
      session_->set_divider(to.x);
      return;
    case Drag::light:
      move_light(to);
      return;
    case Drag::orbit:  // half a turn across the picture
      camera.transform = orbited(camera.transform, pivot_, -way.x * kTurn / 2, way.y * kTurn / 4, session_->up());
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
