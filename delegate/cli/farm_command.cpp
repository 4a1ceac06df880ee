#include <filesystem>

#include "delegate/cli/checkpoint_options.h"
#include "delegate/cli/commands.h"
#include "delegate/cli/exit_codes.h"
#include "delegate/cli/farm_jobs.h"
#include "delegate/cli/outputs.h"
#include "delegate/cli/render_options.h"
#include "delegate/cli/scene_session.h"
#include "delegate/cli/shell_word.h"
#include "delegate/host/product_limits.h"
#include "delegate/support/output_file.h"

namespace alabaster::cli {
namespace {

namespace fs = std::filesystem;

constexpr uint32_t kMostTasks = 10000;

/// Empty if it is no whole number from 1 to kMostTasks.
std::optional<uint32_t> parse_tasks(const std::string& text) {
  if (text.empty() || text.size() > 5 || text.find_first_not_of("0123456789") != std::string::npos) return std::nullopt;
  const auto tasks = static_cast<uint32_t>(std::stoul(text));
  return tasks >= 1 && tasks <= kMostTasks ? std::optional(tasks) : std::nullopt;
}

class FarmCommand {
 public:
  explicit FarmCommand(const FarmArguments& arguments) : a_(arguments), console_(arguments.render.quiet) {}

  int run() {
    int code = check_arguments();
    if (code == kDone) code = count_samples();
    if (code == kDone) code = write();
    if (code == kDone) tell();
    return code;
  }

 private:
  int check_arguments() {
    tasks_ = parse_tasks(a_.tasks).value_or(0);
    if (tasks_ == 0)
      return console_.usage_error(
          "--tasks", "'" + a_.tasks + "' is not a whole number from 1 to " + std::to_string(kMostTasks) + ".");
    if (a_.engine != "slurm" && a_.engine != "openjd" && a_.engine != "script")
      return console_.usage_error("--engine", "'" + a_.engine + "' is not an engine: choose slurm, openjd or script.");
    if (a_.render.outputs.empty()) return console_.usage_error("farm", "There is nothing to write: add -o FILE.");
    for (const auto& [flag, given] :
         {std::pair{"--frames", !a_.render.frames.empty()}, std::pair{"--pixel", !a_.render.pixel.empty()},
          std::pair{"--stats", !a_.render.stats.empty()}})
      if (given) return console_.usage_error(flag, "It cannot be given with farm, which renders one frame in parts.");
    if (const int code = check_values(a_.render, console_); code != kDone) return code;
    std::string problem = same_file_twice(a_.render.outputs);
    products_ = make_products(a_.render, {}, &problem);
    if (!problem.empty()) return console_.usage_error("farm", problem);
    folder_ = a_.folder.empty() ? fs::path(a_.render.scene).stem().string() + "_farm" : a_.folder;
    return describe();
  }

  // The scene is loaded so that its faults are told before the jobs are.
  int count_samples() {
    const hd::description::LoadOptions options = load_options(a_.render);
    if (const int code = load_scene(a_.render, options, console_, console_.sink(), &session_); code != kDone)
      return code;
    RenderArguments part = a_.render;
    part.samples = "0:1", part.checkpoint = "part";
    if (const int code = check_parts(part, session_, 1, console_); code != kDone) return code;
    const auto all = session_.scene.GetAllRenderSettings();
    const hd::RenderSettingsDescription& frame = all.at(session_.file.settings);
    for (const hd::RenderProduct& product : products_)
      if (!hd::host::CheckProductSize(product, frame.window(), console_.sink())) return kUsage;
    const auto found = frame.settings.find("samples");
    if (found == frame.settings.end())
      return console_.usage_error("farm", "The scene does not say how many samples it needs: add --spp N.");
    samples_ = static_cast<uint32_t>(found->second.number_or(0));
    if (samples_ >= tasks_) return kDone;
    return console_.usage_error("--tasks", std::to_string(samples_) + " samples per pixel cannot be shared by " +
                                               a_.tasks + " tasks: each needs one.");
  }

  int describe() {
    std::error_code error;
    const fs::path program = fs::read_symlink("/proc/self/exe", error);
    if (error)
      return console_.usage_error("farm", "/proc/self/exe, which names this program to the jobs, cannot be read: " +
                                              error.message() + ". Mount /proc.");
    const fs::path home = fs::current_path(error);
    if (error)
      return console_.usage_error("farm", "The current folder has no name: " + error.message() +
                                              ". Change to a folder that is there and that may be read.");
    jobs_ = {a_.engine,        program, home,   (home / folder_).string(), a_.render.scene, a_.task_options,
             a_.merge_options, tasks_,  tasks_, a_.render.keep_going};
    const std::string fault = farm_fault(jobs_);
    return fault.empty() ? kDone : console_.usage_error("farm", fault);
  }

  int write() {
    jobs_.samples = samples_;
    std::error_code error;
    fs::create_directories(jobs_.folder, error);
    if (error || !fs::is_directory(jobs_.folder)) {
      console_.error(folder_, "The folder cannot be made; check its name and your permissions.");
      return kOutput;
    }
    for (const fs::directory_entry& entry : fs::directory_iterator(jobs_.folder, error))
      if (entry.path().extension() == ".checkpoint")
        return console_.usage_error(
            "--folder",
            "'" + folder_ + "' holds parts of an earlier farm: remove them, or choose " + "another folder.");
    for (const auto& [name, text] : farm_files(jobs_)) {
      const std::string file = jobs_.folder + "/" + name;
      const std::string problem =
          hd::support::WriteOutputFile(file, {reinterpret_cast<const uint8_t*>(text.data()), text.size()});
      if (problem.empty()) continue;
      console_.error(file, "The job could not be written: " + problem + ".");
      return kOutput;
    }
    return kDone;
  }

  void tell() {
    console_.note("wrote " + std::to_string(tasks_) + " tasks of " + std::to_string(samples_) +
                  " samples per pixel to " + folder_);
    if (a_.engine == "slurm")
      console_.note("run them: sh " + shell_path(folder_ + "/submit.sh"));
    else if (a_.engine == "openjd")
      console_.note("submit " + shell_path(folder_ + "/template.json") + ", or run it here: openjd run " +
                    shell_path(folder_ + "/template.json") +
                    " --step merge --run-dependencies (pip install openjd-cli)");
    else
      console_.note("run each line of " + shell_path(folder_ + "/tasks.txt") +
                    ", on any machine that has these folders; then sh " + shell_path(folder_ + "/merge.sh"));
    console_.note("how far they are: sh " + shell_path(folder_ + "/status.sh"));
  }

  const FarmArguments& a_;
  Console console_;
  SceneSession session_;
  uint32_t tasks_ = 0, samples_ = 0;
  std::string folder_;  // as given
  std::vector<hd::RenderProduct> products_;
  FarmJobs jobs_;
};

}  // namespace

int run_farm(const FarmArguments& arguments) {
  return FarmCommand(arguments).run();
}

}  // namespace alabaster::cli
