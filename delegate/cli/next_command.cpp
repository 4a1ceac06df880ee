#include "delegate/cli/next_command.h"

#include <filesystem>

#include "delegate/cli/view_program.h"
#include "delegate/host/denoiser_library.h"

namespace alabaster::cli {
namespace {

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

}  // namespace

std::string next_command(const RenderArguments& a, const RenderFindings& found) {
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

}  // namespace alabaster::cli
