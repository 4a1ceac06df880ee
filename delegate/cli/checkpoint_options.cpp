#include "delegate/cli/checkpoint_options.h"

#include <filesystem>

#include "delegate/cli/exit_codes.h"
#include "delegate/cli/outputs.h"
#include "delegate/support/output_file.h"

namespace alabaster::cli {
namespace {

std::string checkpoint_file(const RenderArguments& a, uint32_t frame) {
  return a.frames.empty() || a.checkpoint.empty() ? a.checkpoint : frame_file(a.checkpoint, frame);
}

}  // namespace

int check_checkpoint(const RenderArguments& a, Console& console) {
  if (!a.samples.empty() && !parse_samples(a.samples))
    return console.usage_error("--samples", "'" + a.samples +
                                                "' is not a range of samples: write begin:end, such as 256:512 for "
                                                "the samples from 256 to 511; end is at most 1048576.");
  const auto spp = a.settings.find("samples");
  if (!a.samples.empty() && spp != a.settings.end() && !spp->second.empty())
    return console.usage_error("--samples", "It cannot be given with --spp: its end says how many samples there are.");
  if (!a.checkpoint_interval.empty() && !parse_nonnegative(a.checkpoint_interval))
    return console.usage_error("--checkpoint-interval",
                               "'" + a.checkpoint_interval + "' is not a number of seconds from 0 up.");
  if (!a.checkpoint.empty())
    return a.pixel.empty() ? kDone : console.usage_error("--checkpoint", "It cannot be given with --pixel.");
  const char* const flag = a.resume                         ? "--resume"
                           : !a.samples.empty()             ? "--samples"
                           : !a.checkpoint_interval.empty() ? "--checkpoint-interval"
                                                            : nullptr;
  return flag ? console.usage_error(flag, "It needs --checkpoint FILE.") : kDone;
}

int check_checkpoint_files(const RenderArguments& a, Console& console) {
  if (!a.checkpoint.empty() && !a.frames.empty() && frame_file(a.checkpoint, 0).empty())
    return console.usage_error("--checkpoint", "All frames would go to '" + a.checkpoint +
                                                   "': give the name a place for their numbers, such as "
                                                   "part.####.checkpoint.");
  for (const std::string& file : checkpoint_files(a)) {
    if (const std::string fault = hd::support::OutputFault(file); !fault.empty()) {
      console.error(file, fault);
      return kOutput;
    }
    if (!a.resume && std::filesystem::exists(file))
      return console.usage_error("--checkpoint",
                                 "'" + file + "' is there already: add --resume to continue from it, or remove it.");
  }
  return kDone;
}

int check_parts(const RenderArguments& a, const SceneSession& session, size_t renders, Console& console) {
  if (a.checkpoint.empty()) return kDone;
  if (renders > 1)
    return console.usage_error("--checkpoint", "The scene describes " + std::to_string(renders) +
                                                   " renders, and a checkpoint is of one: give -o.");
  const auto all = session.scene.GetAllRenderSettings();
  const hd::Dictionary& settings = all.at(session.file.settings).settings;
  for (const std::string name : {"targetError", "adaptive", "timeLimit"})
    if (const auto found = settings.find(name);
        !a.samples.empty() && found != settings.end() && found->second.number_or(0) != 0)
      return console.usage_error("--samples", "The setting " + name +
                                                  " decides from all samples how many there are, so they cannot be "
                                                  "taken in parts: add --set " +
                                                  name + (name == "adaptive" ? "=false" : "=0") +
                                                  ", or render the frame in one.");
  return kDone;
}

std::vector<std::string> checkpoint_files(const RenderArguments& a) {
  if (a.checkpoint.empty()) return {};
  if (a.frames.empty()) return {a.checkpoint};
  std::vector<std::string> files;
  for (const uint32_t frame : parse_frames(a.frames)) files.push_back(frame_file(a.checkpoint, frame));
  return files;
}

void set_checkpoint(const RenderArguments& a, const hd::RenderSettingsDescription& settings, Console& console,
                    hd::host::RecordOptions* options) {
  const auto frame = settings.settings.find("frame");
  options->checkpoint =
      checkpoint_file(a, frame == settings.settings.end() ? 0 : static_cast<uint32_t>(frame->second.number_or(0)));
  if (const auto seconds = parse_nonnegative(a.checkpoint_interval)) options->checkpoint_seconds = *seconds;
  options->resume = a.resume && std::filesystem::exists(options->checkpoint);
  if (a.resume && !options->resume)
    console.note("there is no checkpoint '" + options->checkpoint + "' yet: the render begins at its first sample");
}

std::vector<std::string> take_part_aovs(const RenderArguments& a, SceneSession* session) {
  hd::RenderSettingsDescription settings = session->scene.GetAllRenderSettings().at(session->file.settings);
  std::vector<std::string> aovs = a.aovs;
  for (const hd::RenderProduct& product : settings.products)
    for (const hd::RenderVar& var : product.vars) aovs.push_back(var.aov.str());
  settings.products.clear();
  session->scene.SetRenderSettings(session->file.settings, std::move(settings));
  return aovs;
}

}  // namespace alabaster::cli
