#include "delegate/view/panels.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <limits>

#include "delegate/host/product_writer.h"

namespace alabaster::view {
namespace {

// Parts of a frame's samples belong to a farm, and memory to the command line.
const std::vector<std::string> kNoSettings{"firstSample", "frame",         "denoise",
                                           "memoryLimit", "textureMemory", "refineEdgeLength"};

std::vector<ParameterRow> setting_rows() {
  std::vector<ParameterRow> rows = parameter_rows("render_settings");
  std::erase_if(rows, [](const ParameterRow& row) {
    return std::find(kNoSettings.begin(), kNoSettings.end(), row.name) != kNoSettings.end();
  });
  return rows;
}

std::vector<std::string> shown_aovs() {
  std::vector<std::string> all = hd::host::ProductAovs();
  std::erase(all, "denoised");
  return all;
}

hd::Value multiplied(const hd::Value& value, double factor) {
  if (const auto* three = value.get<hd::Vec3f>()) return *three * float(factor);
  return value.number_or(0) * factor;
}

std::string short_name(const hd::Path& path) {
  const std::string& text = path.str();
  const size_t slash = text.rfind('/');
  std::string name = slash == std::string::npos ? text : text.substr(slash + 1);
  const size_t digits = name.find_first_not_of("0123456789");
  return digits != 0 && digits != std::string::npos && name[digits] == '_' ? name.substr(digits + 1) : name;
}

// The row of a light's place: three lengths, of which a slider covers the scene's size to both sides.
ParameterRow position_row() {
  ParameterRow row;
  row.name = "position", row.label = "Position", row.unit = "mm";
  row.description = "Place of the light in the scene: x, y and z.";
  row.kind = RowKind::color, row.in_millimetres = row.is_length = true;
  row.minimum = -std::numeric_limits<double>::infinity(), row.maximum = -row.minimum;
  return row;
}

void keep_among(const std::vector<hd::Path>& all, hd::Path* chosen) {
  if (std::find(all.begin(), all.end(), *chosen) == all.end()) *chosen = all.empty() ? hd::Path() : all[0];
}

}  // namespace

Panels::Panels(ViewSession* session, SceneReload* reload, Widgets* widgets, Messages* messages,
               const std::string& scene_file)
    : session_(session),
      reload_(reload),
      widgets_(widgets),
      messages_(messages),
      scene_file_(scene_file),
      material_rows_(parameter_rows("disney_material")),
      light_rows_(parameter_rows("lights")),
      camera_rows_(parameter_rows("camera")),
      setting_rows_(setting_rows()),
      aovs_(shown_aovs()) {
  const std::filesystem::path file(scene_file);
  const std::string stem = (file.parent_path() / file.stem()).string();
  picture_file_ = stem + "_view.png";
  description_file_ = stem + "_view.json";
}

void Panels::show(const std::optional<Picked>& picked) {
  picked_ = picked;
  picked_nothing_ = !picked;
  if (!picked || picked->material.empty()) return;
  const auto& all = session_->edits().materials();
  if (std::find(all.begin(), all.end(), picked->material) == all.end()) return;
  material_ = picked->material;
  select_material_tab_ = true;
}

void Panels::handle_keys() {
  const ImGuiIO& io = ImGui::GetIO();
  if (io.WantTextInput) return;
  const auto pressed = [&](char letter) {
    return std::any_of(io.InputQueueCharacters.begin(), io.InputQueueCharacters.end(),
                       [&](ImWchar typed) { return typed < 128 && std::tolower(typed) == letter; });
  };
  if (pressed(' ')) session_->pause(!session_->paused());
  if (pressed('r')) session_->reset_camera();
  if (pressed('h')) side_shown_ = !side_shown_;
  const int ways = session_->kept_look() ? 2 : 3;  // a kept look takes the place of side by side
  if (pressed('d')) session_->compare(Compare((int(session_->compared()) + 1) % ways));
  if (pressed('w')) keep_or_drop();
  if (pressed('x')) swap();
  if (pressed('l')) reload_->begin();
  if (pressed('[')) session_->set_exposure(session_->exposure() - 0.5f);
  if (pressed(']')) session_->set_exposure(session_->exposure() + 0.5f);
  if (pressed('s')) save_picture();
}

bool Panels::draw_row(const ParameterRow& row, bool changed, bool* reset, hd::Value* value) {
  const std::string unit = unit_text(row).empty() ? "" : " Unit: " + unit_text(row) + ".";
  const ImVec4 color = changed ? ImVec4(1.0f, 0.72f, 0.30f, 1.0f) : ImGui::GetStyleColorVec4(ImGuiCol_Text);
  ImGui::PushStyleColor(ImGuiCol_Text, color);
  label(row.label, row.description + unit);
  ImGui::PopStyleColor();
  const float back = ImGui::GetFrameHeight() + ImGui::GetStyle().ItemInnerSpacing.x;
  ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x - back);
  const auto shown = [this](const hd::Vec3f& color) { return session_->shown(color); };
  const double length = row.in_millimetres ? session_->units_per_millimetre() : 1;
  if (row.in_millimetres) *value = multiplied(*value, 1 / length);
  const bool edited = edit_parameter(widgets_, row, session_->scene_size() / length, shown, value);
  if (row.in_millimetres) *value = multiplied(*value, length);
  if (changed) {
    ImGui::SameLine(ImGui::GetContentRegionMax().x - ImGui::GetFrameHeight());
    *reset = ImGui::Button(("x##reset " + row.name).c_str(), {ImGui::GetFrameHeight(), 0});
    widgets_->mark("reset " + row.name);
    help("Back to the scene's own value.");
  }
  return edited;
}

void Panels::draw_prim(const hd::Path& prim, const std::vector<ParameterRow>& rows) {
  SceneEdits& edits = session_->edits();
  const std::string type = edits.light_type(prim);
  for (const ParameterRow& row : rows) {
    if (!type.empty() && !row.applies_to.empty() &&
        std::find(row.applies_to.begin(), row.applies_to.end(), type) == row.applies_to.end())
      continue;
    const std::string texture = type.empty() ? edits.texture(prim, row.name) : std::string();
    if (!texture.empty()) {
      label(row.label, row.description);
      if (widgets_->button("constant##" + row.name, "Use one value in place of the image."))
        session_->edit(prim, [&] { return edits.set(prim, row, edits.value(prim, row)); });
      ImGui::SameLine();
      ImGui::TextDisabled("%s", std::filesystem::path(texture).filename().c_str());
      help(texture);
      continue;
    }
    bool reset = false;
    hd::Value value = edits.value(prim, row);
    if (draw_row(row, edits.is_changed(prim, row.name), &reset, &value))
      session_->edit(prim, [&] { return edits.set(prim, row, value); });
    if (reset) session_->edit(prim, [&] { return edits.reset(prim, row.name); });
  }
}

void Panels::pick_prim(const char* name, const std::vector<hd::Path>& prims, hd::Path* chosen) {
  std::vector<std::string> items;
  items.reserve(prims.size());
  std::string present = chosen->str();
  for (const hd::Path& path : prims) items.push_back(path.str());
  ImGui::SetNextItemWidth(-1);
  if (widgets_->menu(name, items, &present)) *chosen = hd::Path(present);
}

void Panels::draw_picked() {
  if (!picked_) {
    ImGui::TextDisabled(
        "%s", picked_nothing_ ? "Nothing is there: the background." : "Click on the picture to pick an object.");
    return;
  }
  const hd::host::PickHit& hit = picked_->hit;
  ImGui::TextWrapped("%s", hit.path.str().c_str());
  std::string where = "face " + std::to_string(hit.face);
  for (const auto& instance : hit.instances)
    where += ", instance " + std::to_string(instance.index) + " of " + instance.instancer.str();
  ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled));
  ImGui::TextWrapped("%s, material %s", where.c_str(), short_name(picked_->material).c_str());
  ImGui::PopStyleColor();
}

void Panels::draw_materials() {
  draw_picked();
  ImGui::Separator();
  keep_among(session_->edits().materials(), &material_);
  if (session_->edits().materials().empty()) return ImGui::TextDisabled("The scene has no material to edit.");
  pick_prim("material", session_->edits().materials(), &material_);
  ImGui::BeginChild("parameters");
  draw_prim(material_, material_rows_);
  ImGui::EndChild();
}

void Panels::draw_lights() {
  light_is_shown_ = true;
  SceneEdits& edits = session_->edits();
  std::string added = "Add a light";
  ImGui::SetNextItemWidth(-1);
  if (widgets_->menu("add", {std::begin(kNewLights), std::end(kNewLights)}, &added)) {
    const hd::Vec2d at = picked_ ? picked_->place : hd::Vec2d(0.5, 0.5);
    light_ = session_->add_light(added, at.x, at.y);
  }
  help("It lights what was picked, or the middle of the picture, from the left and above.");
  keep_among(edits.lights(), &light_);
  if (edits.lights().empty()) return ImGui::TextWrapped("The scene has no light prims: its materials emit.");
  pick_prim("light", edits.lights(), &light_);
  draw_light_tools();
  ImGui::BeginChild("parameters");
  draw_position();
  draw_prim(light_, light_rows_);
  ImGui::EndChild();
}

void Panels::draw_light_tools() {
  SceneEdits& edits = session_->edits();
  const std::string type = edits.light_type(light_);
  ImGui::AlignTextToFramePadding();
  ImGui::TextDisabled("%s", type.c_str());
  struct Choice {
    LightTool tool;
    const char *name, *help;
  };
  constexpr Choice kTools[] = {
      {LightTool::move, "Move", "A drag on the picture moves the light with the mouse, parallel to the picture."},
      {LightTool::aim, "Aim", "A click or drag on the picture aims the light at the point under the mouse."},
      {LightTool::highlight, "Highlight",
       "A click or drag on the picture puts the light where it shines at the point under the mouse, and is mirrored "
       "there. It keeps its distance."}};
  for (const Choice& choice : kTools) {
    if (!can_use(choice.tool, type)) continue;
    ImGui::SameLine();
    if (!widgets_->button(choice.name, choice.help, light_tool_ == choice.tool)) continue;
    light_tool_ = light_tool_ == choice.tool ? LightTool::none : choice.tool;
    if (light_tool_ != LightTool::none) session_->bind_surface();
  }
  if (!can_use(light_tool_, type)) light_tool_ = LightTool::none;
  if (!edits.is_added(light_)) return;
  ImGui::SameLine();
  if (!widgets_->button("Remove", "Removes this light, which was added here.")) return;
  session_->edit(light_, [&] { return edits.remove_light(light_), std::string(); });
  keep_among(edits.lights(), &light_);
}

// Place and direction are one parameter, as the light's transform is.
void Panels::draw_position() {
  SceneEdits& edits = session_->edits();
  const bool changed = edits.is_changed(light_, "transform");
  if (!changed && !can_use(LightTool::move, edits.light_type(light_))) return;
  const hd::Matrix4d transform = edits.transform(light_);
  static const ParameterRow kRow = position_row();
  bool reset = false;
  hd::Value value = hd::Vec3f(transform.translation());
  if (draw_row(kRow, changed, &reset, &value)) {
    hd::Matrix4d moved = transform;
    for (int i = 0; i < 3; ++i) moved[3][i] = double(value.get_or(hd::Vec3f(0))[i]);
    session_->edit(light_, [&] { return edits.place(light_, moved); });
  }
  if (reset) session_->edit(light_, [&] { return edits.reset(light_, "transform"); });
}

void Panels::draw_camera() {
  if (widgets_->button("Back to the scene's camera", "Key R")) session_->reset_camera();
  if (picked_) {
    ImGui::SameLine();
    if (widgets_->button("Focus on the pick")) {
      const hd::Vec2d at = picked_->place;
      hd::CameraDescription camera = session_->camera();
      if (const auto depth = session_->depth_at(at.x, at.y)) {
        camera.parameters["focusDistance"] = float(*depth);
        session_->set_camera(camera);
      }
    }
  }
  if (session_->camera_moves())
    ImGui::TextWrapped("%s", session_->is_camera_motion_kept()
                                 ? "This camera moves while the shutter is open. It stands still once it is placed "
                                   "elsewhere."
                                 : "The camera stands still where it was placed. Objects keep their motion.");
  ImGui::BeginChild("parameters");
  for (const ParameterRow& row : camera_rows_) {
    hd::CameraDescription camera = session_->camera();
    const auto found = camera.parameters.find(row.name);
    hd::Value value = found == camera.parameters.end() ? row.default_value : found->second;
    bool reset = false;
    if (!draw_row(row, false, &reset, &value)) continue;
    camera.parameters[row.name] =
        row.kind == RowKind::choice ? hd::Value(hd::Token(value.text_or(""))) : stored_value(row, value);
    session_->set_camera(camera);
  }
  ImGui::EndChild();
}

void Panels::draw_side() {
  light_is_shown_ = false;
  if (!ImGui::BeginTabBar("tabs")) return;
  const ImGuiTabItemFlags flags = select_material_tab_ ? ImGuiTabItemFlags_SetSelected : 0;
  select_material_tab_ = false;
  const bool material = ImGui::BeginTabItem("Material", nullptr, flags);
  widgets_->mark("Material");
  if (material) {
    draw_materials();
    ImGui::EndTabItem();
  }
  const std::string messages = "Messages";
  using Draw = void (Panels::*)();
  for (const auto& [name, draw] : {std::pair<std::string, Draw>{"Light", &Panels::draw_lights},
                                   {"Camera", &Panels::draw_camera},
                                   {"Render", &Panels::draw_render},
                                   {"Save", &Panels::draw_save},
                                   {messages, &Panels::draw_messages}}) {
    const bool alarm = name == messages && messages_->alarms() > seen_alarms_;
    if (alarm) ImGui::PushStyleColor(ImGuiCol_Text, ImVec4(1.0f, 0.5f, 0.4f, 1.0f));
    const bool open = widgets_->tab(name);
    if (alarm) ImGui::PopStyleColor();
    if (!open) continue;
    (this->*draw)();
    ImGui::EndTabItem();
  }
  ImGui::EndTabBar();
}

void Panels::draw_messages() {
  seen_alarms_ = messages_->alarms();
  const auto all = messages_->all();
  if (all.empty()) return ImGui::TextDisabled("No messages.");
  if (widgets_->button("Clear")) messages_->clear();
  ImGui::BeginChild("messages");
  for (const Messages::Entry& entry : all) {
    const hd::Diagnostic& d = entry.diagnostic;
    const ImVec4 color = d.severity == hd::Severity::error     ? ImVec4(1.0f, 0.45f, 0.4f, 1.0f)
                         : d.severity == hd::Severity::warning ? ImVec4(1.0f, 0.8f, 0.35f, 1.0f)
                                                               : ImVec4(0.75f, 0.75f, 0.75f, 1.0f);
    ImGui::PushStyleColor(ImGuiCol_Text, color);
    const std::string times = entry.count > 1 ? " (" + std::to_string(entry.count) + " times)" : "";
    ImGui::TextWrapped("%s%s%s%s", d.where.c_str(), d.where.empty() ? "" : ": ", d.text.c_str(), times.c_str());
    ImGui::PopStyleColor();
    ImGui::Spacing();
  }
  ImGui::EndChild();
}

}  // namespace alabaster::view
