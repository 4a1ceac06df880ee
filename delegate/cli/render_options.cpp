#include "delegate/cli/render_options.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "delegate/cli/exit_codes.h"
#include "delegate/cli/outputs.h"
#include "delegate/description/quality_presets.h"

namespace alabaster::cli {
namespace {

// The bound on samples where an error or a time ends the render. It is never below the preset's own.
int most_samples(const RenderArguments& a) {
  const auto* preset = hd::description::FindQualityPreset(a.quality);
  if (!preset) return kMostSamplesToAnError;
  const double own = preset->settings.at("samples").number_or(0);
  return std::max(kMostSamplesToAnError, static_cast<int>(own));
}

}  // namespace

int check_values(const RenderArguments& a, Console& console) {
  if (const int code = check_scene_arguments(a, console); code != kDone) return code;
  if (const std::string fault = size_fault(a.size); !fault.empty()) return console.usage_error("--size", fault);
  if (!a.crop.empty() && !parse_crop(a.crop))
    return console.usage_error(
        "--crop",
        "'" + a.crop +
            "' is not a rectangle: write four whole numbers, x0,y0,x1,y1, each from -2147483648 to 2147483647.");
  if (!a.shutter.empty() && !parse_interval(a.shutter))
    return console.usage_error("--shutter", "'" + a.shutter + "' is not a shutter: write open:close in frames.");
  if (!a.fps.empty() && parse_nonnegative(a.fps).value_or(0) == 0)
    return console.usage_error("--fps", "'" + a.fps + "' is not a number of frames per second above 0.");
  if (a.exposure && !(std::abs(*a.exposure) <= 64))
    return console.usage_error("--exposure", "expected a number of stops from -64 to 64.");
  return kDone;
}

double seconds_at(const RenderArguments& a, uint32_t frame) {
  return frame / parse_nonnegative(a.fps).value_or(24);
}

hd::description::LoadOptions load_options(const RenderArguments& a) {
  hd::description::LoadOptions options = scene_load_options(a);
  options.overrides.clear();  // those of --set come last
  const auto add = [&](const std::string& key, const std::string& value) {
    if (!value.empty()) options.overrides.push_back(key + "=" + value);
  };
  const std::vector<uint32_t> frames = parse_frames(a.frames);
  if (!frames.empty()) options.time = seconds_at(a, frames[0]);
  if (const auto shutter = parse_interval(a.shutter)) options.shutter = {shutter->first, shutter->second};
  options.frames_per_second = 1 / seconds_at(a, 1);
  if (const auto size = parse_size(a.size))
    add("resolution", "[" + std::to_string(size->x) + "," + std::to_string(size->y) + "]");
  if (parse_crop(a.crop)) add("crop", "[" + a.crop + "]");
  add("quality", a.quality);  // first, so that all others override it
  std::map<std::string, std::string> settings = a.settings;
  if (a.denoise) settings["denoise"] = "true";
  if (!a.pixel.empty()) {
    settings["targetError"] = settings["timeLimit"] = "0";  // the samples of an even frame
    settings["denoise"] = "false";
  }
  const auto is_set = [&](const char* name) {  // 0 is none. A text that is no number is refused where it is read.
    return !settings[name].empty() && parse_nonnegative(settings[name]) != 0.0;
  };
  const bool decided = is_set("targetError") || is_set("timeLimit");
  if (decided && settings["samples"].empty()) settings["samples"] = std::to_string(most_samples(a));
  for (const auto& [name, value] : settings) add(name, value);
  options.overrides.insert(options.overrides.end(), a.overrides.begin(), a.overrides.end());
  if (const auto range = parse_samples(a.samples)) {  // last: no override may change a part's samples
    add("firstSample", std::to_string(range->first));
    add("samples", std::to_string(range->second));
  }
  options.keep_going = a.keep_going;
  return options;
}

std::string noise_text(const hd::Dictionary& stats) {
  const auto percent = [&](const char* key) {
    const auto found = stats.find(key);
    return found == stats.end() ? -1 : 100 * found->second.number_or(-1);
  };
  const double error = percent("error.relativeRmse");
  if (!(error >= 0) || std::isinf(error)) return {};
  const double low = percent("error.low"), high = percent("error.high");
  const auto is_known = stats.find("error.isKnown");
  char noise[120], after[80];
  if (is_known == stats.end() || is_known->second.get_or(true))
    std::snprintf(noise, sizeof noise, "%.2f %% relative RMSE (95 %%: %.2f to %.2f, a factor of %.2f)", error, low,
                  high, high / low);
  else if (low > 0)
    std::snprintf(noise, sizeof noise, "not known, at least %.2f %% relative RMSE (few samples found much light)", low);
  else
    std::snprintf(noise, sizeof noise, "not known (no sample differs from another)");
  std::snprintf(after, sizeof after, " after %.0f samples per pixel%s", stats.at("numCompletedSamples").number_or(0),
                stats.contains("denoiser") ? ", before denoising" : "");
  return std::string("noise: ") + noise + after;
}

}  // namespace alabaster::cli
