#include "delegate/cli/farm_jobs.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "delegate/cli/shell_word.h"

namespace alabaster::cli {
namespace {

/// Writes the files of one farm.
class Writer {
 public:
  explicit Writer(const FarmJobs& jobs) : jobs_(jobs) {}

  std::map<std::string, std::string> files() const {
    std::map<std::string, std::string> all{{"inputs.txt", jobs_.inputs},
                                           {"task.sh", jobs_.frames.empty() ? task() : task_of_frames()}};
    if (jobs_.frames.empty())
      all["merge.sh"] = "#!/bin/sh\n# Adds up all parts and writes the frame: the bytes of one machine's.\n" +
                        at_home() + all_parts() + "exec " + run("merge", jobs_.merge_options) + inputs() +
                        " -- \"$@\"\n";
    all["farm.json"] = farm_text();
    if (jobs_.engine == "slurm") {
      all["job.sbatch"] = slurm_array();
      all["submit.sh"] = slurm_submission();
    } else if (jobs_.engine == "openjd") {
      all["template.json"] = job_template();
    } else {
      all["tasks.txt"] = commands();
    }
    return all;
  }

 private:
  std::string in_folder(const std::string& name) const { return jobs_.folder + "/" + name; }
  std::string inputs() const { return " --inputs " + shell_word(in_folder("inputs.txt")); }

  /// In the folder and with the variables of the machine that wrote the jobs.
  std::string at_home() const {
    std::string text = "set -eu\ncd -- " + shell_word(jobs_.home) + "\n";
    for (const auto& [name, value] : jobs_.variables)
      text += value ? "export " + name + "=" + shell_word(*value) + "\n" : "unset " + name + "\n";
    return text;
  }

  std::string run(const std::string& command, const std::vector<std::string>& options) const {
    std::string text = shell_word(jobs_.program) + " " + command;
    for (const std::string& option : options) text += " " + shell_word(option);
    return text;
  }

  /// What `alabaster farm status` needs to know.
  std::string farm_text() const {
    nlohmann::ordered_json farm = {{"home", jobs_.home}, {"tasks", jobs_.tasks}};
    if (jobs_.frames.empty())
      farm["samples"] = jobs_.samples;
    else
      farm["frames"] = jobs_.frames, farm["stats"] = jobs_.stats;
    return farm.dump(1, ' ', true, nlohmann::ordered_json::error_handler_t::replace) + "\n";
  }

  /// What the task writes, in the words of its script.
  std::string of_task(const std::string& kind, const std::string& extension) const {
    return shell_word(in_folder(kind + ".")) + "\"$(printf %05d \"$1\")\"." + extension;
  }
  std::string running() const { return " --running " + of_task("task", "running"); }

  std::string all_parts() const {
    return "set --\nk=0\nwhile [ $k -lt " + std::to_string(jobs_.tasks) + " ]; do\n  set -- \"$@\" " +
           shell_word(in_folder("part.")) + "\"$(printf %05d $k)\".checkpoint\n  k=$((k + 1))\ndone\n";
  }

  std::string task() const {
    const std::string n = std::to_string(jobs_.tasks), spp = std::to_string(jobs_.samples);
    // The shell becomes the program, which then gets the signals of the farm.
    return "#!/bin/sh\n# task.sh K: renders part K of the samples, from 0 to " + std::to_string(jobs_.tasks - 1) +
           ". Run again, it goes on; a part that is whole stays as it is.\n" + at_home() +
           "[ \"${1:-}\" -ge 0 ] 2>/dev/null && [ \"$1\" -lt " + n + " ] || { echo \"usage: task.sh K, from 0 to " +
           std::to_string(jobs_.tasks - 1) + "\" >&2; exit 2; }\nfirst=$(($1 * " + spp + " / " + n +
           "))\nend=$((($1 + 1) * " + spp + " / " + n + "))\nexec " + run("render", jobs_.task_options) + inputs() +
           " --quiet" + running() + " --stats " + of_task("stats", "json") +
           " --samples \"$first:$end\" --resume --checkpoint " + of_task("part", "checkpoint") + " -- " +
           shell_word(jobs_.scene) + "\n";
  }

  std::string task_of_frames() const {
    std::string text =
        "#!/bin/sh\n# task.sh K: renders the frames of task K. Run again, it leaves out those that are "
        "whole.\n" +
        at_home() + "case \"${1:-}\" in\n";
    for (size_t k = 0; k < jobs_.frames.size(); ++k)
      text += std::to_string(k) + ") frames=" + jobs_.frames[k] + " ;;\n";
    return text + "*) echo \"usage: task.sh K, from 0 to " + std::to_string(jobs_.tasks - 1) +
           "\" >&2; exit 2 ;;\nesac\nexec " + run("render", jobs_.task_options) + inputs() + " --quiet" + running() +
           " --frames=\"$frames\" --skip-existing --stats " + shell_word(in_folder(jobs_.stats)) + " -- " +
           shell_word(jobs_.scene) + "\n";
  }

  /// A line for each task, for engines that take commands.
  std::string commands() const {
    std::string lines;
    for (uint32_t k = 0; k < jobs_.tasks; ++k)
      lines += "sh " + shell_word(in_folder("task.sh")) + " " + std::to_string(k) + "\n";
    return lines;
  }

  std::string slurm_array() const {
    return "#!/bin/sh\n# Slurm has rules of its own for quotes in these lines, so no name stands in them.\n"
           "#SBATCH --job-name=alabaster\n#SBATCH --array=0-" +
           std::to_string(jobs_.tasks - 1) + "\n#SBATCH --requeue\nexec sh " + shell_word(in_folder("task.sh")) +
           " \"$SLURM_ARRAY_TASK_ID\"\n";
  }

  /// The option that names a log, of which Slurm replaces what follows a %.
  std::string slurm_log(const std::string& name) const {
    std::string folder;
    for (const char c : jobs_.folder) folder += c == '%' ? "%%" : std::string(1, c);
    return shell_word("--output=" + folder + "/" + name);
  }

  std::string slurm_submission() const {
    if (!jobs_.frames.empty())
      return "#!/bin/sh\n# Submits the tasks with the options of sbatch that are given, such as --partition. Run again "
             "after tasks were\n# lost: frames that are whole stay as they are.\nexec sbatch " +
             slurm_log("task_%a.log") + " \"$@\" -- " + shell_word(in_folder("job.sbatch")) + "\n";
    return "#!/bin/sh\n# Submits the tasks, and the merge for when all are whole, with the options of sbatch that are "
           "given, such as\n# --partition. Run again after tasks were lost: parts that are whole stay as they are.\n"
           "set -eu\njob=$(sbatch --parsable " +
           slurm_log("task_%a.log") + " \"$@\" -- " + shell_word(in_folder("job.sbatch")) +
           ")\nsbatch --dependency=afterok:\"${job%%;*}\" --kill-on-invalid-dep=yes --job-name=alabaster-merge " +
           slurm_log("merge.log") + " \"$@\" -- " + shell_word(in_folder("merge.sh")) + "\n";
  }

  /// A job of Open Job Description, specification jobtemplate-2023-09: the tasks, and the merge after them.
  std::string job_template() const {
    using nlohmann::ordered_json;
    const auto step = [](const char* name, const std::vector<std::string>& words) {
      const ordered_json action = {{"command", "sh"}, {"args", words}};
      return ordered_json{{"name", name}, {"script", {{"actions", {{"onRun", action}}}}}};
    };
    ordered_json render = step("render", {in_folder("task.sh"), "{{Task.Param.Part}}"});
    const ordered_json part = {{"name", "Part"}, {"type", "INT"}, {"range", "0-" + std::to_string(jobs_.tasks - 1)}};
    render["parameterSpace"]["taskParameterDefinitions"] = ordered_json::array({part});
    ordered_json steps = ordered_json::array({render});
    if (jobs_.frames.empty()) {
      steps.push_back(step("merge", {in_folder("merge.sh")}));
      steps.back()["dependencies"] = ordered_json::array({ordered_json{{"dependsOn", "render"}}});
    }
    const ordered_json job = {{"specificationVersion", "jobtemplate-2023-09"}, {"name", "alabaster"}, {"steps", steps}};
    return job.dump(2, ' ', true) + "\n";
  }

  const FarmJobs& jobs_;
};

/// The reason why a job of Open Job Description cannot name the folder; empty if it can.
std::string template_fault(const std::string& folder) {
  try {
    static_cast<void>(nlohmann::json(folder).dump());
  } catch (const nlohmann::json::exception&) {
    return "the folder's name is not UTF-8, as Open Job Description needs it; choose another one with --folder.";
  }
  for (const auto& [braces, does] : {std::pair("{{", "begins"), std::pair("}}", "ends")})
    if (folder.find(braces) != std::string::npos)
      return "'" + folder + "' has " + braces + ", which " + does +
             " a variable in Open Job Description; choose another folder with --folder.";
  return {};
}

}  // namespace

std::string task_file(const std::string& kind, uint32_t task, const std::string& extension) {
  constexpr size_t kDigits = 5;
  const std::string number = std::to_string(task);
  return kind + "." + std::string(kDigits - std::min(kDigits, number.size()), '0') + number + "." + extension;
}

std::string farm_fault(const FarmJobs& jobs) {
  std::vector<std::pair<std::string, const std::string*>> names{{"The name of the scene", &jobs.scene},
                                                                {"The name of the folder for the jobs", &jobs.folder},
                                                                {"The name of the current folder", &jobs.home},
                                                                {"The name of the program", &jobs.program}};
  for (const auto* options : {&jobs.task_options, &jobs.merge_options})
    for (const std::string& option : *options) names.emplace_back("The option", &option);
  for (const auto& [name, value] : jobs.variables)
    if (value) names.emplace_back("The variable $" + name, &*value);
  for (const auto& [kind, name] : names)
    if (has_control_character(*name))
      return kind + ", '" + without_control_characters(*name) +
             "', has a control character, such as the end of a line. Jobs hold none: rename the file or folder, or "
             "leave the character out.";
  if (jobs.engine == "slurm" && jobs.folder.find('\\') != std::string::npos)
    return "'" + jobs.folder +
           "' has a backslash, with which Slurm numbers no logs; choose another folder with --folder.";
  return jobs.engine == "openjd" ? template_fault(jobs.folder) : std::string();
}

std::map<std::string, std::string> farm_files(const FarmJobs& jobs) {
  return Writer(jobs).files();
}

}  // namespace alabaster::cli
