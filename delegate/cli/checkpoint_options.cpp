#include "delegate/cli/checkpoint_options.h"

#include <filesystem>

#include "delegate/cli/exit_codes.h"
#include "delegate/cli/outputs.h"
#include "delegate/support/lookup.h"
#include "delegate/support/output_file.h"

namespace alabaster::cli {
namespace {

std::string checkpoint_file(const RenderArguments& a, uint32_t frame) {
  return a.frames.empty() || a.checkpoint.empty() ? a.checkpoint : frame_file(a.checkpoint, frame);
}

}  // namespace

void check_checkpoint_files(const RenderArguments& a, Console& console) {
  if (!a.checkpoint.empty() && !a.frames.empty() && frame_file(a.checkpoint, 0).empty())
    console.usage_error("--checkpoint", "All frames would go to '" + a.checkpoint +
                                            "': give the name a place for their numbers, such as "
                                            "part.####.checkpoint.");
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
  const auto all = session.scene.GetAllRenderSettings();
  const hd::Dictionary& settings = all.at(session.file.settings).settings;
  for (const std::string name : {"targetError", "adaptive", "timeLimit"})
    if (a.samples && hd::support::number_in(settings, name.c_str()) != 0)
      console.usage_error("--samples", "The setting " + name +
                                           " decides from all samples how many there are, so they cannot be "
                                           "taken in parts: add --set " +
                                           name + (name == "adaptive" ? "=false" : "=0") +
                                           ", or render the frame in one.");
}

std::vector<std::string> checkpoint_files(const RenderArguments& a) {
  if (a.checkpoint.empty()) return {};
  if (a.frames.empty()) return {a.checkpoint};
  std::vector<std::string> files;
  for (const uint32_t frame : a.frames) files.push_back(frame_file(a.checkpoint, frame));
  return files;
}

void set_checkpoint(const RenderArguments& a, const hd::RenderSettingsDescription& settings, Console& console,
                    hd::host::RecordOptions* options) {
  options->checkpoint = checkpoint_file(a, static_cast<uint32_t>(hd::support::number_in(settings.settings, "frame")));
  if (a.checkpoint_interval) options->checkpoint_seconds = *a.checkpoint_interval;
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
