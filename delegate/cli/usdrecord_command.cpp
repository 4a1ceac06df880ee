// alabaster usdrecord: a render by the options, lines and defaults of OpenUSD's program of that name.
#include <algorithm>

#include "delegate/cli/commands.h"
#include "delegate/cli/console.h"
#include "delegate/cli/exit_codes.h"

namespace alabaster::cli {
namespace {

/// Words between commas and spaces.
std::vector<std::string> words_of(const std::string& text) {
  std::vector<std::string> words;
  for (size_t at = 0; (at = text.find_first_not_of(", ", at)) != std::string::npos;) {
    const size_t end = std::min(text.find_first_of(", ", at), text.size());
    words.push_back(text.substr(at, end - at));
    at = end;
  }
  return words;
}

/// The one placeholder of a name, "###" or "###.###"; empty: it has none, or several.
std::string placeholder_of(const std::string& file) {
  const size_t first = file.find('#');
  if (first == std::string::npos) return {};
  size_t end = std::min(file.find_first_not_of('#', first), file.size());
  if (end + 1 < file.size() && file[end] == '.' && file[end + 1] == '#')
    end = std::min(file.find_first_not_of('#', end + 1), file.size());
  return file.find('#', end) == std::string::npos ? file.substr(first, end - first) : std::string();
}

void check_placeholder(const UsdrecordArguments& u, Console& console) {
  const std::string placeholder = placeholder_of(u.output);
  if (!u.frames) {
    if (!placeholder.empty())
      console.usage_error("usdrecord",
                          "'" + u.output + "' has a place for a frame's number, but there is no --frames.");
    return;
  }
  if (placeholder.empty())
    console.usage_error("--frames", "'" + u.output + "' must have one place for the frames' numbers: ### or ###.###.");
  const size_t point = placeholder.find('.');
  const size_t digits = point == std::string::npos ? 0 : placeholder.size() - point - 1;
  if (digits < u.frames->digits)
    console.usage_error("--frames", "These time codes need " + std::to_string(u.frames->digits) +
                                        " digits after the point, and '" + u.output + "' has " +
                                        std::to_string(digits) + ": write for example ###." +
                                        std::string(u.frames->digits, '#') + ".");
}

}  // namespace

int run_usdrecord(UsdrecordArguments u) {
  Console console(u.render.quiet);
  RenderArguments& render = u.render;
  hd::host::StageOptions& stage = render.stage;
  if (!stage.settings.empty() && !stage.pass.empty())
    console.usage_error("usdrecord", "Give --renderSettingsPrimPath or --renderPassPrimPath, not both.");
  if (u.frames && u.default_time) console.usage_error("usdrecord", "Give --frames or --defaultTime, not both.");
  check_placeholder(u, console);
  stage.recorded_width = std::max(u.width, 1);
  stage.hides_domes = !u.shows_domes;
  stage.at_default_time = u.default_time;
  stage.mask = words_of(u.mask);
  stage.purposes = {"default"};
  for (const std::string& purpose : words_of(u.purposes)) {
    if (purpose != "default" && purpose != "render" && purpose != "proxy" && purpose != "guide")
      console.usage_error("--purposes", "'" + purpose + "' is no purpose: choose from render, proxy and guide.");
    if (purpose != "default") stage.purposes.push_back(purpose);
  }
  stage.camera = u.camera;
  if (!render.complexity) render.complexity = 0;
  if (u.frames) render.frames = u.frames->codes;
  render.outputs = {u.output};
  if (u.color_correction != "openColorIO") render.color_space = u.color_correction == "sRGB" ? "sRGB" : "raw";
  if (!u.renderer.empty() && u.renderer != "Alabaster")
    console.note("note: Alabaster renders, in the place of the renderer '" + u.renderer + "'");
  if (!u.without_camera_light)
    console.note("note: no light is added at the camera; a stage without lights has those of a studio");
  return run_render(render);
}

}  // namespace alabaster::cli
