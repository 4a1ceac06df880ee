#include "delegate/cli/render_messages.h"

#include <algorithm>
#include <cmath>

#include "delegate/cli/outputs.h"
#include "delegate/cli/render_options.h"
#include "delegate/host/denoiser_library.h"
#include "delegate/support/lookup.h"
#include "delegate/support/process_usage.h"
#include "delegate/support/size_text.h"

namespace alabaster::cli {
namespace {

using hd::support::number_in;
using hd::support::size_option;

std::string size_of(const hd::Rect2i& window) {
  return size_option(window.width(), window.height());
}

/// The relative RMSE of statistics; negative: not known.
double noise_in(const hd::Dictionary& stats) {
  const double noise = number_in(stats, "error.relativeRmse", -1);
  return number_in(stats, "error.isKnown", 1) != 0 && std::isfinite(noise) ? noise : -1;
}

/// The same for the samples that were taken since it was measured: it falls with the square root of their number.
double present_noise_in(const hd::Dictionary& stats) {
  const double measured = number_in(stats, "error.samples"), present = number_in(stats, "numCompletedSamples");
  return noise_in(stats) * (measured > 0 && present > measured ? std::sqrt(measured / present) : 1);
}

// Relative RMSE above which a picture looks grainy, and above which its denoised one lacks detail.
constexpr double kGrainy = 0.05, kTooNoisyToDenoise = 0.25;

/// A command that takes the scene, its overrides and --allow-outside alone.
Words about_scene(const std::string& command, const RenderArguments& a) {
  Words words{command, a.scene.starts_with("-") ? "./" + a.scene : a.scene};
  for (const std::string& assignment : a.overrides) words.insert(words.end(), {"--set", assignment});
  if (a.allow_outside) words.emplace_back("--allow-outside");
  return words;
}

std::string with_purpose(const Words& words, const std::string& purpose) {
  const std::string command = command_text(words);
  return command.empty() ? command : command + "  # " + purpose;
}

/// The result of a render, as far as a next command depends on it.
struct RenderFindings {
  bool degraded = false;    // rendered without all of its scene
  bool warned = false;      // there were warnings of the scene
  bool has_camera = false;  // of its own
  bool has_light = false;
  bool denoised = false;
  double noise = -1;  // relative RMSE before denoising; negative: not known
};

/// "alabaster ...  # purpose": the one command that improves the picture most. Empty if it would hold a word that
/// cannot be copied.
std::string next_command(const RenderArguments& a, const RenderFindings& found) {
  if (a.words.empty()) return {};  // of another command
  if (found.degraded) return with_purpose(about_scene("check", a), "all that the picture lacks");
  // The AOVs of a checkpoint may not change, and denoising adds some.
  const bool grainy = found.noise > (found.denoised ? kTooNoisyToDenoise : kGrainy) && a.checkpoint.empty();
  if (grainy && !found.denoised && hd::host::DenoiserFault().empty())
    return with_purpose(with_options(a.words, {}, {"--denoise"}), "the same without its noise");
  if (grainy)
    return with_purpose(with_options(a.words, {"--spp", "--target-error", "--time-limit"}, {"--target-error", "0.05"}),
                        "until the noise is 5 %");
  if (found.warned) return with_purpose(about_scene("check", a), "the warnings again, without rendering");
  if (!found.has_camera && !view_program().empty())
    return with_purpose(about_scene("view", a), "look around, and save a camera");
  if (!found.has_light)
    return with_purpose(with_options(a.words, {"--dome"}, {"--dome", "1,1,1"}), "an even sky in place of the studio");
  return with_purpose(about_scene("info", a), "the materials and meshes, and how to change them");
}

}  // namespace

RenderMessages::RenderMessages(const RenderArguments& arguments, const SceneSession& session, Console* console)
    : a_(arguments), session_(session), console_(*console) {}

void RenderMessages::progress(const hd::RenderSettingsDescription& frame, const hd::host::RecordProgress& progress) {
  if (a_.quiet) return;
  if (!begun_) begin(frame, progress);
  const double noise = noise_so_far(progress.seconds);
  if (!estimated_) estimate(frame, progress, noise);
  console_.progress(progress, noise);
}

// A measurement takes a little of a render thread's time.
double RenderMessages::noise_so_far(double seconds) {
  constexpr double kPause = 3;
  if (seconds < asked_) asked_ = 0;  // another frame
  if (seconds >= asked_ + kPause) {
    session_.delegate()->InvokeCommand("measureNoise", {});
    asked_ = seconds;
  }
  return present_noise_in(session_.delegate()->GetRenderStats());
}

void RenderMessages::begin(const hd::RenderSettingsDescription& frame, const hd::host::RecordProgress& progress) {
  begun_ = true;
  warned_ = console_.warnings() > 0;
  const double target = number_in(frame.settings, "targetError"), limit = number_in(frame.settings, "timeLimit");
  std::string text = "rendering " + size_of(frame.window());
  if (frame.crop) text += " of " + size_option(frame.width, frame.height);
  if (target > 0) text += formatted(" to %.3g %% noise", 100 * target);
  if (limit > 0) text += formatted(target > 0 ? ", for %g s at most" : " for %g s", limit);
  if (!(target > 0) && !(limit > 0)) text += ", " + std::to_string(progress.samples_total) + " samples per pixel";
  console_.note(text);
}

// The first seconds tell how long a render takes; to a target error, its first noise. A limit of time alone says it
// itself.
void RenderMessages::estimate(const hd::RenderSettingsDescription& frame, const hd::host::RecordProgress& progress,
                              double noise) {
  constexpr double kMeasured = 3, kLong = 20;  // seconds
  if (progress.seconds < kMeasured || !(progress.fraction > 0 && progress.fraction < 1)) return;
  if (number_in(frame.settings, "targetError") > 0 && noise < 0) return;
  estimated_ = true;
  const double one = progress.seconds / progress.fraction;
  const auto frames = double(std::max<size_t>(a_.frames.numbers.size(), 1));
  const bool by_time_alone =
      number_in(frame.settings, "timeLimit") > 0 && !(number_in(frame.settings, "targetError") > 0);
  if (one * frames < kLong || by_time_alone) return;
  std::string text = "expected time: " + time_text(one);
  if (frames > 1) text += formatted(" a frame, %.0f frames: ", frames) + time_text(one * frames);
  console_.note(text + shorter(frame));
}

std::string RenderMessages::shorter(const hd::RenderSettingsDescription& frame) const {
  if (a_.samples) return {};  // a part of a farm's frame
  const auto is_preset = [](const hd::description::Override& one) { return one.place == "quality"; };
  const bool preset = std::any_of(a_.settings.begin(), a_.settings.end(), is_preset);
  return std::string(". Shorter: ") + (preset ? "" : "--quality preview, ") + "--size " +
         size_option(std::max(frame.width / 2, 1), std::max(frame.height / 2, 1)) + ", --time-limit 20";
}

void RenderMessages::add(const hd::RenderSettingsDescription& frame, const hd::host::RecordResult& result) {
  const bool is_alone = a_.frames.numbers.empty();
  if (is_alone)
    for (const std::string& file : result.written)
      for (const hd::RenderProduct& product : frame.products)
        if (product.file == file) written_.emplace_back(file, size_of(product_window(frame, product)));
  noise_ = noise_in(result.stats);
  denoised_ = result.stats.contains("denoiser") && !result.stats.contains("denoise.error");
  if (const std::string text = noise_text(result.stats); is_alone && !text.empty()) console_.note(text);
}

void RenderMessages::end_frame(double number, size_t done, double seconds, const std::vector<std::string>& written) {
  const size_t all = a_.frames.numbers.size();
  std::string text = formatted("frame %g: %zu of %zu done", number, done, all);
  if (noise_ >= 0) text += formatted(", noise %.2f %%", 100 * noise_);
  for (const std::string& file : written) text += ", wrote " + file;
  if (done < all) text += ", " + time_text(seconds * double(all - done)) + " left";
  console_.note(text);
}

void RenderMessages::summarize(const RunStats& stats, bool degraded) {
  const double rays =
      stats.total("rays.camera") + stats.total("rays.bounce") + stats.total("rays.shadow") + stats.total("rays.walk");
  const double load = stats.load_wall(), sync = stats.total("phase.sync.wall"),
               render = stats.total("phase.render.wall"), write = stats.total("phase.write.wall");
  for (const auto& [file, size] : written_) console_.note("wrote " + file + ", " + size + " pixels");
  console_.note(
      formatted("time: %.2f s (load %.2f s, sync %.2f s, render %.2f s, write %.2f s); %.1f Mrays; peak memory %.0f MB",
                load + sync + render + write, load, sync, render, write, rays / 1e6,
                double(hd::support::peak_memory_bytes()) / 1e6));
  if (a_.samples || a_.quiet) return;
  RenderFindings found;
  found.degraded = degraded;
  found.warned = warned_;
  found.has_camera = !session_.file.framed;
  found.has_light = session_.file.has_light;
  found.denoised = denoised_;
  found.noise = noise_;
  if (const std::string next = next_command(a_, found); !next.empty()) console_.note("next: " + next);
}

}  // namespace alabaster::cli
