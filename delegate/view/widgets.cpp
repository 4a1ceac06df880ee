#include "delegate/view/widgets.h"

#include <imgui_stdlib.h>

#include <algorithm>
#include <cmath>

#include "delegate/cli/console.h"

namespace alabaster::view {
namespace {

float encoded(float c) {
  return c <= 0.0031308f ? 12.92f * c : 1.055f * std::pow(c, 1 / 2.4f) - 0.055f;
}
float decoded(float c) {
  return c <= 0.04045f ? c / 12.92f : std::pow((c + 0.055f) / 1.055f, 2.4f);
}

// A format of few digits, "0 (none)" for example, must not round what the slider gives.
constexpr ImGuiSliderFlags kAsMoved = ImGuiSliderFlags_NoRoundToFormat;

bool edit_number(Widgets* widgets, const ParameterRow& row, double scene_size, hd::Value* value) {
  const double before = value->number_or(0);
  const SoftRange range = soft_range(row, before, scene_size);
  const ImGuiSliderFlags flags = kAsMoved | (range.logarithmic ? ImGuiSliderFlags_Logarithmic : 0);
  if (row.kind == RowKind::integer) {
    int whole = int(std::lround(std::clamp(before, range.low, range.high)));
    const bool moved = ImGui::SliderInt(("##" + row.name).c_str(), &whole, int(range.low), int(range.high),
                                        value_format(row, range, before).c_str(), flags);
    widgets->mark(row.name);
    if (moved) *value = limited(row, whole);
    return moved;
  }
  auto number = float(before);
  if (!widgets->slider(row.name, &number, float(range.low), float(range.high), value_format(row, range, before).c_str(),
                       flags))
    return false;
  *value = limited(row, double(number));
  return true;
}

// The swatch shows what the display shows; its picker works with sRGB, as screens do, and the numbers are linear.
bool edit_swatch(const ParameterRow& row, const std::function<hd::Vec3f(hd::Vec3f)>& shown, hd::Vec3f* color) {
  const hd::Vec3f seen = shown(*color);
  const std::string popup = "picker of " + row.name;
  if (ImGui::ColorButton(("##swatch" + row.name).c_str(), {seen.x, seen.y, seen.z, 1}, ImGuiColorEditFlags_NoTooltip))
    ImGui::OpenPopup(popup.c_str());
  if (!ImGui::BeginPopup(popup.c_str())) return false;
  float srgb[3];
  for (int i = 0; i < 3; ++i) srgb[i] = encoded(std::clamp((*color)[i], 0.0f, 1.0f));
  const bool changed =
      ImGui::ColorPicker3("##picker", srgb, ImGuiColorEditFlags_NoInputs | ImGuiColorEditFlags_NoAlpha);
  if (changed)
    for (int i = 0; i < 3; ++i) (*color)[i] = decoded(srgb[i]);
  ImGui::EndPopup();
  return changed;
}

bool edit_color(Widgets* widgets, const ParameterRow& row, double scene_size,
                const std::function<hd::Vec3f(hd::Vec3f)>& shown, hd::Value* value) {
  hd::Vec3f color = value->get_or(hd::Vec3f(0));
  const bool length = row.is_length;
  bool changed = false;
  const double largest = double(std::max({color.x, color.y, color.z}));
  const SoftRange range = soft_range(row, largest, scene_size);
  const float swatch = length ? 0 : ImGui::GetFrameHeight() + ImGui::GetStyle().ItemInnerSpacing.x;
  const float width = (ImGui::CalcItemWidth() - swatch - 2 * ImGui::GetStyle().ItemInnerSpacing.x) / 3;
  // There is no room for the unit of three numbers.
  ParameterRow bare = row;
  bare.unit.clear();
  const std::string format = length ? value_format(bare, range, largest) : "%.3f";
  for (int i = 0; i < 3; ++i) {
    if (i > 0) ImGui::SameLine(0, ImGui::GetStyle().ItemInnerSpacing.x);
    ImGui::SetNextItemWidth(width);
    const std::string name = row.name + "." + "rgb"[i];
    changed |= widgets->slider(name, &color[i], float(range.low), float(range.high), format.c_str(),
                               kAsMoved | (range.logarithmic ? ImGuiSliderFlags_Logarithmic : 0));
  }
  if (!length) {
    ImGui::SameLine(0, ImGui::GetStyle().ItemInnerSpacing.x);
    changed |= edit_swatch(row, shown, &color);
  }
  if (changed) *value = color;
  return changed;
}

}  // namespace

const Widgets::Place* Widgets::find(const std::string& name) const {
  const auto found = places_.find(name);
  return found == places_.end() ? nullptr : &found->second;
}

void Widgets::mark(const std::string& name) {
  places_[name] = {ImGui::GetItemRectMin(), ImGui::GetItemRectMax(), ImGui::IsItemVisible()};
  if (name == sought_) ImGui::SetScrollHereY();
}

bool Widgets::button(const std::string& name, const char* text, bool lit) {
  if (lit) ImGui::PushStyleColor(ImGuiCol_Button, ImGui::GetStyleColorVec4(ImGuiCol_ButtonActive));
  const bool pressed = ImGui::Button(name.c_str());
  if (lit) ImGui::PopStyleColor();
  mark(name);
  if (text) help(text);
  return pressed;
}

bool Widgets::tick(const std::string& name, bool* value, const char* text) {
  const bool changed = ImGui::Checkbox(("##" + name).c_str(), value);
  mark(name);
  if (text) help(text);
  return changed;
}

bool Widgets::menu(const std::string& name, const std::vector<std::string>& items, std::string* chosen) {
  const bool open = ImGui::BeginCombo(("##" + name).c_str(), chosen->c_str(), ImGuiComboFlags_HeightLarge);
  mark(name);
  if (!open) return false;
  bool changed = false;
  for (const std::string& item : items) {
    if (ImGui::Selectable(item.c_str(), item == *chosen) && item != *chosen) *chosen = item, changed = true;
    mark(name + "/" + item);
  }
  ImGui::EndCombo();
  return changed;
}

bool Widgets::field(const std::string& name, std::string* text) {
  const bool changed = ImGui::InputText(("##" + name).c_str(), text);
  mark(name);
  return changed;
}

bool Widgets::slider(const std::string& name, float* value, float low, float high, const char* format,
                     ImGuiSliderFlags flags) {
  const bool changed = ImGui::SliderFloat(("##" + name).c_str(), value, low, high, format, flags);
  mark(name);
  return changed;
}

bool Widgets::tab(const std::string& name) {
  const bool open = ImGui::BeginTabItem(name.c_str());
  mark(name);
  return open;
}

std::string percent(double share) {
  return cli::formatted(share < 0.0995 ? "%.2g %%" : "%.0f %%", 100 * share);
}

void help(const std::string& text) {
  if (!ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled) || text.empty()) return;
  ImGui::BeginTooltip();
  ImGui::PushTextWrapPos(ImGui::GetFontSize() * 28);
  ImGui::TextUnformatted(text.c_str());
  ImGui::PopTextWrapPos();
  ImGui::EndTooltip();
}

void label(const std::string& text, const std::string& explanation) {
  ImGui::AlignTextToFramePadding();
  ImGui::TextUnformatted(text.c_str());
  help(explanation);
  ImGui::SameLine(ImGui::GetCursorStartPos().x + 12.5f * ImGui::GetFontSize());
}

bool edit_parameter(Widgets* widgets, const ParameterRow& row, double scene_size,
                    const std::function<hd::Vec3f(hd::Vec3f)>& shown, hd::Value* value) {
  if (row.kind == RowKind::toggle) {
    bool on = value->number_or(0) != 0;
    if (!widgets->tick(row.name, &on)) return false;
    *value = on;
    return true;
  }
  if (row.kind == RowKind::choice) {
    std::string chosen = value->text_or("");
    if (!widgets->menu(row.name, row.choices, &chosen)) return false;
    *value = chosen;
    return true;
  }
  if (row.kind == RowKind::color) return edit_color(widgets, row, scene_size, shown, value);
  if (row.kind == RowKind::text) {
    const std::string text = value->text_or("");
    ImGui::TextDisabled("%s", text.empty() ? "none" : text.c_str());
    return false;
  }
  return edit_number(widgets, row, scene_size, value);
}

}  // namespace alabaster::view
