// alabaster usdrecord: a render by the options, lines and defaults of OpenUSD's program of that name.
#include <algorithm>

#include "delegate/cli/commands.h"
#include "delegate/cli/console.h"
#include "delegate/cli/exit_codes.h"
#include "delegate/cli/outputs.h"

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

void check_places(const UsdrecordArguments& u, Console& console) {
  const auto place = frame_place(u.output);
  if (u.render.frames.numbers.empty() && place)
    console.usage_error("usdrecord", "'" + u.output + "' has a place for a frame's number, but there is no --frames.");
  if (place && frame_place(frame_file(u.output, 0)))
    console.usage_error("usdrecord",
                        "'" + u.output + "' has several places for a frame's number: write one ### or ###.###.");
}

}  // namespace

int run_usdrecord(UsdrecordArguments u) {
  Console console(u.render.quiet);
  RenderArguments& render = u.render;
  hd::host::StageOptions& stage = render.stage;
  if (!stage.settings.empty() && !stage.pass.empty())
    console.usage_error("usdrecord", "Give --renderSettingsPrimPath or --renderPassPrimPath, not both.");
  if (!render.frames.numbers.empty() && u.default_time)
    console.usage_error("usdrecord", "Give --frames or --defaultTime, not both.");
  check_places(u, console);
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
  render.outputs = {u.output};
  if (u.color_correction != "openColorIO") render.color_space = u.color_correction == "sRGB" ? "sRGB" : "raw";
  if (!u.renderer.empty() && u.renderer != "Alabaster")
    console.note("note: Alabaster renders, in the place of the renderer '" + u.renderer + "'");
  if (!u.without_camera_light)
    console.note("note: no light is added at the camera; a stage without lights has those of a studio");
  return run_render(render);
}

}  // namespace alabaster::cli
