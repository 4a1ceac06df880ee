#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "delegate/cli/checkpoint_options.h"
#include "delegate/cli/commands.h"
#include "delegate/cli/exit_codes.h"
#include "delegate/cli/outputs.h"
#include "delegate/cli/render_options.h"
#include "delegate/cli/scene_session.h"
#include "delegate/cli/shell_word.h"
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
    const auto products = make_products(a_.render, {}, &problem);
    if (!problem.empty()) return console_.usage_error("farm", problem);
    folder_ = a_.folder.empty() ? fs::path(a_.render.scene).stem().string() + "_farm" : a_.folder;
    return kDone;
  }

  // The scene is loaded so that its faults are told before the jobs are.
  int count_samples() {
    const hd::description::LoadOptions options = load_options(a_.render);
    if (const int code = load_scene(a_.render, options, console_, console_.sink(), &session_); code != kDone)
      return code;
    RenderArguments part = a_.render;
    part.samples = "0:1", part.checkpoint = "part";
    if (const int code = check_parts(part, session_, 1, console_); code != kDone) return code;
    const hd::Dictionary& settings = session_.scene.GetAllRenderSettings().at(session_.file.settings).settings;
    const auto found = settings.find("samples");
    if (found == settings.end())
      return console_.usage_error("farm", "The scene does not say how many samples it needs: add --spp N.");
    samples_ = static_cast<uint32_t>(found->second.number_or(0));
    if (samples_ >= tasks_) return kDone;
    return console_.usage_error("--tasks", std::to_string(samples_) + " samples per pixel cannot be shared by " +
                                               a_.tasks + " tasks: each needs one.");
  }

  int write() {
    std::error_code error;
    place_ = fs::absolute(folder_, error).string();
    if (a_.engine == "openjd")
      if (const std::string fault = template_fault(); !fault.empty()) return console_.usage_error("--folder", fault);
    fs::create_directories(folder_, error);
    const std::string program = fs::read_symlink("/proc/self/exe", error).string();
    if (error || !fs::is_directory(place_)) {
      console_.error(folder_, "The folder cannot be made; check its name and your permissions.");
      return kOutput;
    }
    for (const fs::directory_entry& entry : fs::directory_iterator(place_, error))
      if (entry.path().extension() == ".checkpoint")
        return console_.usage_error(
            "--folder",
            "'" + folder_ + "' holds parts of an earlier farm: remove them, or choose " + "another folder.");
    const std::string at_home = "set -eu\ncd " + shell_word(fs::current_path(error).string()) + "\n";
    const std::string run = shell_word(program);
    const std::string n = std::to_string(tasks_), spp = std::to_string(samples_);
    // A part that was rendered with --keep-going without all of its scene counts as rendered.
    const std::string task_end =
        a_.render.keep_going ? " || code=$?\n[ \"${code:-0}\" -eq 6 ] || exit \"${code:-0}\"\n" : "\n";
    const std::string all_parts = "set --\nk=0\nwhile [ $k -lt " + n + " ]; do\n  set -- \"$@\" " + shell_word(place_) +
                                  "/part.\"$(printf %05d $k)\".checkpoint\n  k=$((k + 1))\ndone\n";
    std::map<std::string, std::string> files;
    files["task.sh"] = "#!/bin/sh\n# task.sh K: renders part K of the samples, from 0 to " +
                       std::to_string(tasks_ - 1) + ". Run again, it goes on; a part that is whole stays as it is.\n" +
                       at_home + "first=$(($1 * " + spp + " / " + n + "))\nend=$((($1 + 1) * " + spp + " / " + n +
                       "))\n" + run + " render " + shell_word(a_.render.scene) + a_.render_words +
                       " --quiet --samples \"$first:$end\" --resume --checkpoint " + shell_word(place_) +
                       "/part.\"$(printf %05d \"$1\")\".checkpoint" + task_end;
    files["merge.sh"] = "#!/bin/sh\n# Adds up all parts and writes the frame: the bytes of one machine's.\n" + at_home +
                        all_parts + "exec " + run + " merge \"$@\"" + a_.merge_words + "\n";
    files["status.sh"] =
        "#!/bin/sh\n# Tells how far the parts are, and the noise so far. A task saves its part each minute.\n" +
        at_home + all_parts + "exec " + run + " merge \"$@\"\n";
    if (a_.engine == "slurm")
      add_slurm(&files);
    else if (a_.engine == "openjd")
      files["template.json"] = job_template();
    else
      files["tasks.txt"] = commands();
    for (const auto& [name, text] : files)
      if (const std::string problem = hd::support::WriteOutputFile(
              place_ + "/" + name, {reinterpret_cast<const uint8_t*>(text.data()), text.size()});
          !problem.empty()) {
        console_.error(place_ + "/" + name, "The job could not be written: " + problem + ".");
        return kOutput;
      }
    return kDone;
  }

  /// A line for each task, for engines that take commands.
  std::string commands() const {
    std::string lines;
    for (uint32_t k = 0; k < tasks_; ++k)
      lines += "sh " + shell_word(place_ + "/task.sh") + " " + std::to_string(k) + "\n";
    return lines;
  }

  /// The reason why a job of Open Job Description cannot name the folder; empty if it can.
  std::string template_fault() const {
    try {
      static_cast<void>(nlohmann::json(place_).dump());
    } catch (const nlohmann::json::exception&) {
      return "the folder's name is not UTF-8, as Open Job Description needs it; choose another folder.";
    }
    if (place_.find("{{") == std::string::npos) return {};
    return "'" + place_ + "' has {{, which begins a variable in Open Job Description; choose another folder.";
  }

  /// A job of Open Job Description, specification jobtemplate-2023-09: the tasks, and the merge after them.
  std::string job_template() const {
    using nlohmann::ordered_json;
    const auto step = [](const char* name, const std::vector<std::string>& words) {
      const ordered_json action = {{"command", "sh"}, {"args", words}};
      return ordered_json{{"name", name}, {"script", {{"actions", {{"onRun", action}}}}}};
    };
    ordered_json render = step("render", {place_ + "/task.sh", "{{Task.Param.Part}}"});
    const ordered_json part = {{"name", "Part"}, {"type", "INT"}, {"range", "0-" + std::to_string(tasks_ - 1)}};
    render["parameterSpace"]["taskParameterDefinitions"] = ordered_json::array({part});
    ordered_json merge = step("merge", {place_ + "/merge.sh"});
    merge["dependencies"] = ordered_json::array({ordered_json{{"dependsOn", "render"}}});
    const ordered_json job = {{"specificationVersion", "jobtemplate-2023-09"},
                              {"name", "alabaster"},
                              {"steps", ordered_json::array({render, merge})}};
    return job.dump(2) + "\n";
  }

  void add_slurm(std::map<std::string, std::string>* files) const {
    // Slurm reads names of logs as patterns.
    std::string logs;
    for (const char c : place_) logs += c == '%' ? "%%" : std::string(1, c);
    const std::string log = shell_word(logs + "/task_%a.log");
    (*files)["job.sbatch"] = "#!/bin/sh\n#SBATCH --job-name=alabaster\n#SBATCH --array=0-" +
                             std::to_string(tasks_ - 1) + "\n#SBATCH --output=" + log +
                             "\n#SBATCH --requeue\nexec sh " + shell_word(place_ + "/task.sh") +
                             " \"$SLURM_ARRAY_TASK_ID\"\n";
    (*files)["submit.sh"] =
        "#!/bin/sh\n# Submits the tasks, and the merge for when all are whole, with the options of sbatch that are "
        "given, such "
        "as\n# --partition. Run again after tasks were lost: parts that are whole stay as they are.\nset -eu\n"
        "job=$(sbatch --parsable \"$@\" " +
        shell_word(place_ + "/job.sbatch") +
        ")\nsbatch --dependency=afterok:\"${job%%;*}\" --kill-on-invalid-dep=yes --job-name=alabaster-merge --output=" +
        shell_word(logs + "/merge.log") + " \"$@\" " + shell_word(place_ + "/merge.sh") + "\n";
  }

  void tell() {
    console_.note("wrote " + std::to_string(tasks_) + " tasks of " + std::to_string(samples_) +
                  " samples per pixel to " + folder_);
    if (a_.engine == "slurm")
      console_.note("run them: sh " + shell_word(folder_ + "/submit.sh"));
    else if (a_.engine == "openjd")
      console_.note("submit " + shell_word(folder_ + "/template.json") + ", or run it here: openjd run " +
                    shell_word(folder_ + "/template.json") +
                    " --step merge --run-dependencies (pip install openjd-cli)");
    else
      console_.note("run each line of " + shell_word(folder_ + "/tasks.txt") +
                    ", on any machine that has these folders; then sh " + shell_word(folder_ + "/merge.sh"));
    console_.note("how far they are: sh " + shell_word(folder_ + "/status.sh"));
  }

  const FarmArguments& a_;
  Console console_;
  SceneSession session_;
  uint32_t tasks_ = 0, samples_ = 0;
  std::string folder_, place_;  // as given, and absolute
};

}  // namespace

int run_farm(const FarmArguments& arguments) {
  return FarmCommand(arguments).run();
}

}  // namespace alabaster::cli
