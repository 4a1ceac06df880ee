#include <algorithm>
#include <filesystem>
#include <utility>

#include "delegate/cli/commands.h"
#include "delegate/cli/exit_codes.h"
#include "delegate/cli/farm_jobs.h"
#include "delegate/cli/outputs.h"
#include "delegate/cli/picture_inputs.h"
#include "delegate/cli/render_options.h"
#include "delegate/cli/scene_session.h"
#include "delegate/cli/shell_word.h"
#include "delegate/support/lookup.h"
#include "delegate/support/nearest_name.h"

namespace alabaster::cli {
namespace {

namespace fs = std::filesystem;

class FarmCommand {
 public:
  explicit FarmCommand(FarmArguments arguments) : a_(std::move(arguments)), console_(a_.render.quiet) {}

  int run() {
    check_arguments();
    describe();
    look_at_scene();
    list_inputs();
    write();
    tell();
    return kDone;
  }

 private:
  void check_arguments() {
    if (const Words& known = farm_engines(); std::find(known.begin(), known.end(), a_.engine) == known.end())
      console_.usage_error("--engine", "'" + a_.engine + "' is not an engine: choose from " + joined(known) + "." +
                                           hd::support::Suggestion(a_.engine, known));
    if (a_.render.outputs.empty())
      console_.usage_error("farm",
                           "There is nothing to write: add -o FILE. Products of the scene are not written by a farm.");
    for (const auto& [flag, given] :
         {std::pair{"--pixel", a_.render.pixel.has_value()}, std::pair{"--stats", !a_.render.stats.empty()},
          std::pair{"--skip-existing", a_.render.skip_existing}})
      if (given) console_.usage_error(flag, "It cannot be given with farm, whose tasks write files of their own.");
    divide_frames();
    console_.require_usage("farm", same_file_twice(a_.render.outputs));
    products_ = make_products(a_.render, {}, "farm", console_);
    folder_ = a_.folder.empty() ? fs::path(a_.render.scene).stem().string() + "_farm" : a_.folder;
  }

  // Each task gets frames that follow each other in the list.
  void divide_frames() {
    std::vector<double>& frames = a_.render.frames.numbers;
    if (a_.render.turntable && frames.empty())
      for (uint32_t frame = 1; frame <= *a_.render.turntable; ++frame) frames.push_back(frame);
    constexpr uint32_t kMostTasks = 10000;
    if (a_.tasks == 0 && frames.size() > kMostTasks)
      console_.usage_error("--tasks", "There are more than 10000 frames: add --tasks N.");
    if (a_.tasks == 0) a_.tasks = static_cast<uint32_t>(frames.size());
    if (a_.tasks == 0) console_.usage_error("farm", "--tasks is required.");
    if (frames.empty()) {
      if (a_.render.start_frame) console_.usage_error("--start-frame", "It needs --frames.");
      return;
    }
    if (a_.render.time && !a_.render.turntable)
      console_.usage_error("--frames", "It cannot be given with --time, which shows one frame.");
    check_frame_names(a_.render.outputs, a_.render, console_);
    if (frames.size() < a_.tasks)
      console_.usage_error("--tasks", std::to_string(frames.size()) + " frames cannot be shared by " +
                                          std::to_string(a_.tasks) + " tasks: each needs one.");
    for (size_t k = 0; k < a_.tasks; ++k)
      frames_.push_back(list_of(frames, k * frames.size() / a_.tasks, (k + 1) * frames.size() / a_.tasks));
  }

  /// As --frames takes it: runs of whole numbers are ranges.
  static std::string list_of(const std::vector<double>& frames, size_t begin, size_t end) {
    std::string text;
    for (size_t first = begin, last; first < end; first = last + 1) {
      last = first;
      while (last + 1 < end && frames[last + 1] == frames[last] + 1) ++last;
      text += (text.empty() ? "" : ",") + formatted("%.10g", frames[first]);
      if (last > first) text += formatted(":%.10g", frames[last]);
    }
    return text;
  }

  // The scene is loaded so that its faults are told before the jobs are.
  void look_at_scene() {
    open_scene(a_.render, load_options(a_.render), console_, console_.sink(), &session_);
    const bool is_of_frames = !frames_.empty();
    if (is_of_frames && session_.file.framed && !a_.render.turntable)
      console_.usage_error("--frames",
                           "The camera is framed by the first frame of each task, so it would jump: describe one in "
                           "the scene, or render with one task.");
    if (!is_of_frames) check_divisible("--tasks", session_, console_);
    const auto all = session_.scene.GetAllRenderSettings();
    const hd::RenderSettingsDescription& frame = all.at(session_.file.settings);
    for (const hd::RenderProduct& product : products_) {
      const auto check = hd::host::CheckProduct(product, frame.window(), session_.colors(), {});
      const bool is_of_machine = check.status == hd::host::ProductStatus::output;  // others may have the folder
      if (!check && !is_of_machine) console_.fail(exit_code(check.status, true), product.file, check.text);
    }
    if (is_of_frames) return;
    const auto found = frame.settings.find("samples");
    if (found == frame.settings.end())
      console_.usage_error("farm", "The scene does not say how many samples it needs: add --spp N.");
    samples_ = static_cast<uint32_t>(found->second.number_or(0));
    if (samples_ < a_.tasks)
      console_.usage_error("--tasks", std::to_string(samples_) + " samples per pixel cannot be shared by " +
                                          std::to_string(a_.tasks) + " tasks: each needs one.");
  }

  void describe() {
    std::error_code error;
    const fs::path program = fs::read_symlink("/proc/self/exe", error);
    if (error)
      console_.usage_error("farm", "/proc/self/exe, which names this program to the jobs, cannot be read: " +
                                       error.message() + ". Mount /proc.");
    const fs::path home = fs::current_path(error);
    if (error)
      console_.usage_error("farm", "The current folder has no name: " + error.message() +
                                       ". Change to a folder that is there and that may be read.");
    jobs_ = {a_.engine,        program,  home,    (home / folder_).string(), a_.render.scene, a_.task_options,
             a_.merge_options, a_.tasks, a_.tasks};
    jobs_.frames = frames_;
    const size_t digits = a_.render.frames.digits;
    if (!frames_.empty()) jobs_.stats = "stats.####" + (digits > 0 ? "." + std::string(digits, '#') : "") + ".json";
    console_.require_usage("farm", farm_fault(jobs_));
  }

  bool is_denoised() const {
    const auto all = session_.scene.GetAllRenderSettings();
    return hd::support::number_in(all.at(session_.file.settings).settings, "denoise") != 0;
  }

  // The configuration goes by its variable, because a merge does not read the scene, which may name it.
  void list_inputs() {
    const auto colors = hd::host::ReadColorInputs(session_.colors(), console_.sink());
    if (!colors) throw Exit{kInput};
    PictureInputs inputs;
    add_colors(*colors, &inputs);
    add_files(session_, a_.render.scene, &inputs);
    if (is_denoised()) add_denoiser(&inputs);
    jobs_.inputs = to_text(inputs);
    jobs_.variables = colors->variables;
    jobs_.variables["OCIO"] = colors->origin;
    console_.require_usage("farm", farm_fault(jobs_));
  }

  void write() {
    jobs_.samples = samples_;
    std::error_code error;
    fs::create_directories(jobs_.folder, error);
    if (error || !fs::is_directory(jobs_.folder))
      console_.fail(kOutput, folder_, "The folder cannot be made; check its name and your permissions.");
    for (const fs::directory_entry& entry : fs::directory_iterator(jobs_.folder, error))
      if (is_of_farm(entry.path().filename())) {
        if (!a_.force)
          console_.usage_error("--folder", "'" + folder_ + "' holds an earlier farm: choose another folder, or add " +
                                               "--force, which removes its jobs and parts.");
        std::error_code kept;
        fs::remove(entry.path(), kept);
      }
    for (const auto& [name, text] : farm_files(jobs_)) console_.write_file(jobs_.folder + "/" + name, text, "The job");
  }

  /// Scripts of its own names and what tasks write beside them; nothing else in the folder is a farm's.
  static bool is_of_farm(const fs::path& name) {
    const std::string file = name.string();
    for (const char* own :
         {"inputs.txt", "farm.json", "task.sh", "merge.sh", "tasks.txt", "job.sbatch", "submit.sh", "template.json"})
      if (file == own) return true;
    return name.extension() == ".checkpoint" || name.extension() == ".running" ||
           (file.starts_with("stats.") && name.extension() == ".json");
  }

  void tell() {
    const bool is_of_frames = !frames_.empty();
    console_.note("wrote " + std::to_string(a_.tasks) + " tasks of " +
                  (is_of_frames ? std::to_string(a_.render.frames.numbers.size()) + " frames"
                                : std::to_string(samples_) + " samples per pixel") +
                  " to " + folder_);
    if (a_.engine == "slurm")
      console_.note("run them: sh " + shell_path(folder_ + "/submit.sh"));
    else if (a_.engine == "openjd")
      console_.note("submit " + shell_path(folder_ + "/template.json") + ", or run it here: openjd run " +
                    shell_path(folder_ + "/template.json") + (is_of_frames ? "" : " --step merge --run-dependencies") +
                    " (pip install openjd-cli)");
    else
      console_.note("run each line of " + shell_path(folder_ + "/tasks.txt") +
                    ", on any machine that has these folders" +
                    (is_of_frames ? std::string() : "; then sh " + shell_path(folder_ + "/merge.sh")));
    console_.note("how far they are: alabaster farm status " + shell_path(folder_));
  }

  FarmArguments a_;
  Console console_;
  SceneSession session_;
  uint32_t samples_ = 0;
  std::string folder_;  // as given
  std::vector<hd::RenderProduct> products_;
  FarmJobs jobs_;
  std::vector<std::string> frames_;  // of each task
};

}  // namespace

int run_farm(const FarmArguments& arguments) {
  if (!arguments.status.folder.empty()) return run_farm_status(arguments.status);
  return FarmCommand(arguments).run();
}

}  // namespace alabaster::cli
