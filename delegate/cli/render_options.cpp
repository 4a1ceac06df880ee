#include "delegate/cli/render_options.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <utility>

#include "delegate/cli/exit_codes.h"
#include "delegate/cli/outputs.h"
#include "delegate/description/quality_presets.h"
#include "delegate/support/lookup.h"
#include "delegate/support/output_file.h"

namespace alabaster::cli {
namespace {

using Overrides = std::vector<hd::description::Override>;

const hd::Value* given(const Overrides& settings, const char* name) {
  const auto found = std::find_if(settings.begin(), settings.end(), [&](const auto& one) { return one.place == name; });
  return found == settings.end() ? nullptr : &found->value;
}

// 0 is none. A text that is no number is refused where it is read.
bool is_set(const Overrides& settings, const char* name) {
  const hd::Value* value = given(settings, name);
  return value && parse_nonnegative(value->text_or("")) != 0.0;
}

// The bound on samples where an error or a time ends the render. It is never below the preset's own.
int most_samples(const Overrides& settings) {
  const hd::Value* quality = given(settings, "quality");
  const auto* preset = quality ? hd::description::FindQualityPreset(quality->text_or("")) : nullptr;
  return preset ? std::max(kMaxSamplesWithTargetError, int(preset->settings.at("samples").number_or(0)))
                : kMaxSamplesWithTargetError;
}

std::string checkpoint_file(const RenderArguments& a, double frame) {
  return a.frames.numbers.empty() || a.checkpoint.empty() ? a.checkpoint : frame_file(a.checkpoint, frame);
}

}  // namespace

uint32_t frame_number(const hd::RenderSettingsDescription& settings) {
  constexpr double kMost = std::numeric_limits<uint32_t>::max();
  return settings.frame > 0 ? static_cast<uint32_t>(std::min(settings.frame, kMost)) : 0;  // 0 where it is no number
}

hd::description::LoadOptions load_options(const RenderArguments& a) {
  Overrides settings = a.settings;
  if (a.denoise) settings.emplace_back("--denoise", "denoise", true);
  if (a.pixel) {
    for (const char* name : {"targetError", "timeLimit"}) settings.emplace_back("--pixel", name, 0);
    settings.emplace_back("--pixel", "denoise", false);  // the samples of an even frame
  } else if ((is_set(settings, "targetError") || is_set(settings, "timeLimit")) && !given(settings, "samples")) {
    settings.emplace_back("--target-error or --time-limit", "samples", most_samples(settings));
  }
  hd::description::LoadOptions options = scene_load_options(a, std::move(settings));
  if (!a.frames.numbers.empty() && !a.turntable) options.frame = a.frames.numbers[0] - a.start_frame.value_or(0);
  if (a.shutter) options.shutter = {a.shutter->first, a.shutter->second};
  const auto is_motion = [](const std::string& given) { return aov_of(given) == "motion"; };
  if (a.turntable)
    options.next_frame = false;  // models keep their pose
  else if (std::any_of(a.aovs.begin(), a.aovs.end(), is_motion))
    options.next_frame = true;
  options.size = a.size, options.crop = a.crop;
  options.frames_per_second = a.fps;
  if (a.samples) {  // last: no override may change a part's samples
    options.overrides.emplace_back("--samples", "firstSample", int64_t(a.samples->first));
    options.overrides.emplace_back("--samples", "samples", int64_t(a.samples->second));
  }
  options.keep_going = a.keep_going;
  return options;
}

std::string noise_text(const hd::Dictionary& stats) {
  const auto percent = [&](const char* key) { return 100 * hd::support::number_in(stats, key, -0.01); };
  const double error = percent("error.relativeRmse");
  if (!(error >= 0) || std::isinf(error)) return {};
  const double low = percent("error.low"), high = percent("error.high");
  std::string noise = "noise: not known (no sample differs from another)";
  if (hd::support::number_in(stats, "error.isKnown", 1) != 0)
    noise =
        formatted("noise: %.2f %% relative RMSE (95 %%: %.2f to %.2f, a factor of %.2f)", error, low, high, high / low);
  else if (low > 0)
    noise = formatted("noise: not known, at least %.2f %% relative RMSE (few samples found much light)", low);
  return noise + formatted(" after %.0f samples per pixel%s", stats.at("numCompletedSamples").number_or(0),
                           stats.contains("denoiser") ? ", before denoising" : "");
}

void check_checkpoint_files(const RenderArguments& a, Console& console) {
  if (!a.checkpoint.empty() && !a.frames.numbers.empty()) check_frame_names({a.checkpoint}, a, console);
  for (const std::string& file : checkpoint_files(a)) {
    console.require(kOutput, file, hd::support::OutputFault(file));
    if (!a.resume && std::filesystem::exists(file))
      console.usage_error("--checkpoint",
                          "'" + file + "' is there already: add --resume to continue from it, or remove it.");
  }
}

void check_parts(const RenderArguments& a, const SceneSession& session, size_t renders, Console& console) {
  if (a.checkpoint.empty()) return;
  if (renders > 1)
    console.usage_error("--checkpoint", "The scene describes " + std::to_string(renders) +
                                            " renders, and a checkpoint is of one: give -o.");
  if (a.samples) check_divisible("--samples", session, console);
}

void check_divisible(const char* option, const SceneSession& session, Console& console) {
  const auto all = session.scene.GetAllRenderSettings();
  const hd::Dictionary& settings = all.at(session.file.settings).settings;
  for (const std::string name : {"targetError", "adaptive", "timeLimit"})
    if (hd::support::number_in(settings, name.c_str()) != 0)
      console.usage_error(option, "The setting " + name +
                                      " decides from all samples how many there are, so they cannot be taken in parts: "
                                      "add --set " +
                                      name + (name == "adaptive" ? "=false" : "=0") + ", or render the frame in one.");
}

std::vector<std::string> checkpoint_files(const RenderArguments& a) {
  if (a.checkpoint.empty()) return {};
  if (a.frames.numbers.empty()) return {a.checkpoint};
  std::vector<std::string> files;
  for (const double frame : a.frames.numbers) files.push_back(frame_file(a.checkpoint, frame));
  return files;
}

void set_checkpoint(const RenderArguments& a, double number, Console& console, hd::host::RecordOptions* options) {
  options->checkpoint = checkpoint_file(a, number);
  if (a.checkpoint_interval) options->checkpoint_seconds = *a.checkpoint_interval;
  options->resume = a.resume && std::filesystem::exists(options->checkpoint);
  if (a.resume && !options->resume)
    console.note("there is no checkpoint '" + options->checkpoint + "' yet: the render begins at its first sample");
}

std::vector<std::string> take_part_aovs(const RenderArguments& a, SceneSession* session,
                                        std::vector<hd::RenderProduct>* of_frame) {
  hd::RenderSettingsDescription settings = session->scene.GetAllRenderSettings().at(session->file.settings);
  std::vector<std::string> aovs;
  for (const std::string& given : a.aovs) aovs.push_back(aov_of(given));
  for (const hd::RenderProduct& product : settings.products)
    for (const hd::RenderVar& var : product.vars) aovs.push_back(var.aov.str());
  *of_frame = std::exchange(settings.products, {});
  session->scene.SetRenderSettings(session->file.settings, std::move(settings));
  return aovs;
}

}  // namespace alabaster::cli
