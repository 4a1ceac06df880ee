// The panels around the picture: toolbar, parameters, settings, messages, status. Internal to this room.
#pragma once

#include "delegate/view/messages.h"
#include "delegate/view/scene_reload.h"
#include "delegate/view/view_session.h"
#include "delegate/view/widgets.h"

namespace alabaster::view {

class Panels {
 public:
  Panels(ViewSession* session, SceneReload* reload, Widgets* widgets, Messages* messages,
         const std::string& scene_file);

  void draw_toolbar();
  void draw_side();
  void draw_status(const ViewStatus& status, const std::optional<hd::Vec2d>& mouse);
  /// Shows what was picked, and its material; empty: nothing.
  void show(const std::optional<Picked>& picked);
  /// Letters and the space bar, where no field has the keyboard.
  void handle_keys();
  bool side_is_shown() const { return side_shown_; }
  /// Half the size renders a quarter of the pixels.
  int reduction() const { return reduction_; }
  /// Of the tab that is shown: what the mouse does to a light, and the light; none and empty for another one.
  LightTool light_tool() const { return light_is_shown_ && side_shown_ ? light_tool_ : LightTool::none; }
  hd::Path shown_light() const { return light_is_shown_ && side_shown_ ? light_ : hd::Path(); }
  /// The status says it for a while.
  void tell(const std::string& text);

 private:
  void draw_compare();
  void draw_materials();
  void draw_lights();
  void draw_light_tools();
  void draw_position();
  void draw_camera();
  void draw_render();
  void draw_quality();
  void draw_save();
  void draw_messages();
  void draw_picked();
  void draw_prim(const hd::Path& prim, const std::vector<ParameterRow>& rows);
  bool draw_row(const ParameterRow& row, bool changed, bool* reset, hd::Value* value);
  void pick_prim(const char* name, const std::vector<hd::Path>& prims, hd::Path* chosen);
  void keep_or_drop();
  void swap();
  void save_picture();
  void tell_saved(bool written, const std::string& file);

  ViewSession* session_;
  SceneReload* reload_;
  Widgets* widgets_;
  Messages* messages_;
  const std::string scene_file_;
  const std::vector<ParameterRow> material_rows_, light_rows_, camera_rows_, setting_rows_;
  std::vector<std::string> aovs_;
  hd::Path material_, light_;
  LightTool light_tool_ = LightTool::none;
  bool light_is_shown_ = false;
  std::optional<Picked> picked_;
  bool picked_nothing_ = false, side_shown_ = true, select_material_tab_ = false;
  std::string picture_file_, description_file_, saved_, told_;
  ViewStatus status_;
  std::vector<float> values_;  // under the mouse
  double values_at_ = 0;       // when they were read
  double told_at_ = -1e9;      // when `told_` was
  int reduction_ = 1;
  uint64_t seen_alarms_ = 0;
};

}  // namespace alabaster::view
