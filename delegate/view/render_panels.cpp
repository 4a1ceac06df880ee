// The panels of a render: toolbar, quality and settings, files, status.
#include <algorithm>

#include "delegate/description/quality_presets.h"
#include "delegate/support/lookup.h"
#include "delegate/view/panels.h"

namespace alabaster::view {
namespace {

constexpr float kNamedWidth = 74;   // of a toolbar with names, in letters
constexpr double kReadAgain = 0.2;  // seconds between two looks at the pixel under the mouse
constexpr double kTold = 5;         // seconds that the status tells of what was done

std::string duration(double seconds) {
  if (seconds < 0) return "unknown";
  if (seconds < 120) return cli::formatted(seconds < 10 ? "%.1f s" : "%.0f s", seconds);
  return seconds < 7200 ? cli::formatted("%.0f min", seconds / 60) : cli::formatted("%.1f h", seconds / 3600);
}

std::string noise_text(const ViewStatus& s) {
  if (s.noise < 0) return "noise not known yet";
  return "noise " + percent(s.noise) + " (" + percent(s.noise_low) + " to " + percent(s.noise_high) + ")";
}

std::string state_text(const ViewStatus& s, bool paused) {
  if (s.state == hd::PassState::failed) return "failed";
  if (paused) return "paused";
  return s.denoised >= 0 && s.denoised < 1 ? "denoising" : s.state_name;
}

}  // namespace

void Panels::draw_toolbar() {
  if (widgets_->button(session_->paused() ? "Continue" : "Pause", "Space bar", session_->paused()))
    session_->pause(!session_->paused());
  ImGui::SameLine();
  const float em = ImGui::GetFontSize();
  std::string aov = session_->aov();
  const bool named = ImGui::GetWindowWidth() > kNamedWidth * em;
  const auto next = [named, em](const char* name, float letters) {
    ImGui::SameLine(0, named ? em : -1);
    if (named) {
      ImGui::AlignTextToFramePadding();
      ImGui::TextDisabled("%s", name);
      ImGui::SameLine(0, ImGui::GetStyle().ItemInnerSpacing.x);
    }
    ImGui::SetNextItemWidth(em * letters);
    return name;
  };
  if (widgets_->menu(next("AOV", 9), aovs_, &aov)) session_->show_aov(aov);
  help("Layer that is shown. Light and colours are shown by the display's view, other numbers as colours.");

  std::vector<std::string> displays, views;
  for (const hd::host::ColorDisplay& choice : session_->displays()) {
    displays.push_back(choice.name);
    if (choice.name == session_->display()) views = choice.views;
  }
  std::string display = session_->display(), view = session_->display_view();
  if (widgets_->menu(next("Display", 8), displays, &display)) session_->set_display(display, "");
  help("Display of the OpenColorIO configuration.");
  if (widgets_->menu(next("View", 8), views, &view)) session_->set_display(display, view);
  help("View of that display.");
  float exposure = session_->exposure();
  if (widgets_->slider(next("Exposure", 9), &exposure, -6, 6, "%+.2f stops")) session_->set_exposure(exposure);
  help("Exposure of the display: nothing is rendered again. Keys [ and ]. A click with Ctrl types a number.");
  draw_compare();
}

void Panels::draw_compare() {
  constexpr std::pair<const char*, Compare> kChoices[] = {
      {"Rendered", Compare::rendered}, {"Denoised", Compare::denoised}, {"Side by side", Compare::side_by_side}};
  for (const auto& [name, how] : kChoices) {
    if (session_->kept_look() && how == Compare::side_by_side) continue;
    ImGui::SameLine();
    if (widgets_->button(name, "The picture is denoised after its last sample, or when it is paused. Key D",
                         session_->compared() == how))
      session_->compare(how);
  }
  ImGui::SameLine(0, ImGui::GetFontSize());
  if (widgets_->button("Keep A",
                       "Keeps this look as A, left of a line that the mouse drags, while B, right of it, goes on being "
                       "edited. Again: lets A go. Key W",
                       session_->kept_look() != nullptr))
    keep_or_drop();
  if (session_->kept_look()) {
    ImGui::SameLine();
    if (widgets_->button("Swap", "Goes back to the edits and settings of A, and keeps B as A. Key X")) swap();
  }
  ImGui::SameLine(0, ImGui::GetFontSize());
  if (widgets_->button(
          reload_->is_busy() ? "Loading" : "Reload",
          "Reads the scene's files again, and keeps the edits and the camera. It is lit when a file has changed. Key L",
          reload_->has_changed() || reload_->is_busy()))
    reload_->begin();
}

void Panels::keep_or_drop() {
  if (session_->kept_look())
    session_->drop_look();
  else if (!session_->keep_look())
    tell("There is no picture to keep yet.");
}

void Panels::swap() {
  if (session_->kept_look() && !session_->swap_looks()) tell("There is no picture to keep yet.");
}

void Panels::draw_quality() {
  std::vector<std::string> names{"as the scene says"};
  const std::optional<std::string> preset_in_force = session_->quality();
  std::string quality = !preset_in_force ? "as set below" : preset_in_force->empty() ? names[0] : *preset_in_force;
  for (const auto& preset : hd::description::QualityPresets()) names.push_back(preset.name);
  label("Quality");
  ImGui::SetNextItemWidth(-1);
  if (widgets_->menu("Quality", names, &quality)) {
    for (const ParameterRow& row : setting_rows_)
      if (session_->is_setting_changed(row.name)) session_->reset_setting(row.name);
    session_->apply_quality(quality);
  }
  const std::string known =
      status_.noise < 0 ? ". The noise is known from two samples on." : ", " + noise_text(status_);
  ImGui::TextWrapped("Now: %u %s in %s%s", status_.samples, status_.samples == 1 ? "sample" : "samples",
                     duration(status_.seconds).c_str(), known.c_str());
  if (ImGui::BeginTable("presets", 3, ImGuiTableFlags_BordersInnerH | ImGuiTableFlags_SizingStretchProp)) {
    for (const char* heading : {"Preset", "Noise", "Time from now on"}) ImGui::TableSetupColumn(heading);
    ImGui::TableHeadersRow();
    for (const auto& preset : hd::description::QualityPresets()) {
      const double noise = hd::support::number_in(preset.settings, "targetError");
      const double left = seconds_to(status_, noise);
      ImGui::TableNextColumn();
      ImGui::TextUnformatted(preset.name.c_str());
      help(preset.description);
      ImGui::TableNextColumn();
      ImGui::TextUnformatted(noise > 0 ? percent(noise).c_str() : "-");
      ImGui::TableNextColumn();
      ImGui::TextUnformatted(left == 0 ? "reached" : duration(left).c_str());
    }
    ImGui::EndTable();
  }
  ImGui::TextDisabled("Times are those of the present settings and size.");
}

void Panels::draw_render() {
  draw_quality();
  std::string size = reduction_ == 1 ? "as large as shown" : "1/" + std::to_string(reduction_) + " of that";
  label("Pixels");
  ImGui::SetNextItemWidth(-1);
  if (widgets_->menu("Pixels", {"as large as shown", "1/2 of that", "1/4 of that"}, &size))
    reduction_ = size[0] == 'a' ? 1 : size[2] - '0';
  ImGui::Separator();
  ImGui::BeginChild("settings");
  for (const ParameterRow& row : setting_rows_) {
    bool reset = false;
    hd::Value value = session_->setting(row.name);
    if (value.empty()) value = row.default_value;
    if (draw_row(row, session_->is_setting_changed(row.name), &reset, &value)) session_->set_setting(row, value);
    if (reset) session_->reset_setting(row.name);
  }
  ImGui::EndChild();
}

void Panels::tell(const std::string& text) {
  told_ = text;
  told_at_ = ImGui::GetTime();
}

void Panels::tell_saved(bool written, const std::string& file) {
  saved_ = written ? "Wrote " + file : file + " was not written: see Messages.";
  tell(saved_);
}

void Panels::save_picture() {
  tell_saved(session_->save_picture(picture_file_, scene_file_), picture_file_);
}

void Panels::draw_save() {
  ImGui::TextWrapped(
      "The picture, as it is now: .png, .tif and .jpg as displayed, .exr as rendered, with the layer shown.");
  ImGui::SetNextItemWidth(-1);
  widgets_->field("picture file", &picture_file_);
  if (widgets_->button("Save picture", "Key S")) save_picture();
  ImGui::Separator();
  ImGui::TextWrapped(
      "A render description (.json) of the scene with all that was changed here: camera, materials, "
      "lights, settings. The scene's own files stay as they are.");
  ImGui::SetNextItemWidth(-1);
  widgets_->field("description file", &description_file_);
  if (widgets_->button("Save description"))
    tell_saved(session_->save_description(description_file_, scene_file_), description_file_);
  ImGui::Separator();
  ImGui::TextWrapped("%s", saved_.c_str());
  ImGui::Separator();
  ImGui::TextWrapped("Reload, or key L, reads the scene's files again.");
  widgets_->tick("reload by itself", &reload_->by_itself);
  ImGui::SameLine();
  ImGui::TextUnformatted("as soon as a file has changed");
}

void Panels::draw_status(const ViewStatus& status, const std::optional<hd::Vec2d>& mouse) {
  status_ = status;
  std::string line = state_text(status, session_->paused()) +
                     cli::formatted("   %u of %u samples   ", status.samples, status.samples_total) +
                     duration(status.seconds) + "   " + noise_text(status);
  const double target = session_->setting("targetError").number_or(0);
  const double goal = target > 0 ? target : 0.02, left = seconds_to(status, goal);
  if (left > 0) line += "   " + percent(goal) + " in about " + duration(left);
  if (status.denoised >= 0 && status.denoised < 1) line += "   denoising " + percent(status.denoised);
  if (!status.fault.empty()) line += "   " + status.fault;
  if (status.scene_faults > 0) line += "   " + std::to_string(status.scene_faults) + " faults: see Messages";
  if (ImGui::GetTime() - told_at_ < kTold) line = told_;
  ImGui::TextUnformatted(line.c_str());
  if (mouse && ImGui::GetTime() - values_at_ > kReadAgain) {
    values_ = session_->values_at(mouse->x, mouse->y);
    values_at_ = ImGui::GetTime();
  }
  std::string right;
  if (mouse && !values_.empty()) {
    right = session_->aov();
    for (const float value : values_) right += cli::formatted(" %.4g", double(value));
    right += cli::formatted("  at %d, %d", int(mouse->x * session_->size().x), int(mouse->y * session_->size().y));
  }
  const float end = ImGui::GetContentRegionMax().x, room = end - ImGui::CalcTextSize(line.c_str()).x - 30 * unit();
  const std::string size = cli::formatted("   %d x %d   %3.0f fps", session_->size().x, session_->size().y,
                                          double(ImGui::GetIO().Framerate));
  if (right.empty() || ImGui::CalcTextSize((right + size).c_str()).x <= room) right += size;
  const float width = ImGui::CalcTextSize(right.c_str()).x;
  ImGui::SameLine(end - std::min(width, room));
  ImGui::TextDisabled("%s", right.c_str());
}

}  // namespace alabaster::view
