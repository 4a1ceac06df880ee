// ImGui's widgets, with a log of where each one stands, by which a script finds them. Internal to this room.
#pragma once

#include <imgui.h>

#include <functional>
#include <map>
#include <string>

#include "delegate/view/parameter_rows.h"

namespace alabaster::view {

/// Widgets are known by the name that they show; those of parameters by the schema's.
class Widgets {
 public:
  struct Place {
    ImVec2 low, high;
    bool visible = false;
  };
  void begin_frame() { places_.clear(); }
  /// Where the last frame drew the widget; null: nowhere.
  const Place* find(const std::string& name) const;
  /// The widget is scrolled into sight as long as this is its name.
  void seek(const std::string& name) { sought_ = name; }

  bool button(const std::string& name, const char* help = nullptr, bool lit = false);
  bool tick(const std::string& name, bool* value, const char* help = nullptr);
  /// True when another item was chosen.
  bool menu(const std::string& name, const std::vector<std::string>& items, std::string* chosen);
  bool field(const std::string& name, std::string* text);
  bool slider(const std::string& name, float* value, float low, float high, const char* format,
              ImGuiSliderFlags flags = 0);
  bool tab(const std::string& name);
  /// Notes where the last item is.
  void mark(const std::string& name);

 private:
  std::map<std::string, Place> places_;
  std::string sought_;
};

/// The length of a pixel on a plain screen: a fifteenth of the letters' height.
inline float unit() {
  return ImGui::GetFontSize() / 15;
}

/// A share as people read it.
std::string percent(double share);

/// Explains the last item while the mouse rests on it.
void help(const std::string& text);

/// The name of the widget that follows on the same line, where all widgets begin.
void label(const std::string& text, const std::string& explanation = "");

/// A slider, field or menu for a parameter; true with the new value in *value once the user changes it. `shown` gives a
/// colour as the display shows it.
bool edit_parameter(Widgets* widgets, const ParameterRow& row, double scene_size,
                    const std::function<hd::Vec3f(hd::Vec3f)>& shown, hd::Value* value);

}  // namespace alabaster::view
