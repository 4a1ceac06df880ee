// The files of a farm: the scripts of its tasks, and the job that an engine reads.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace alabaster::cli {

/// Names and options are as the user gave them, not quoted.
struct FarmJobs {
  std::string engine;   // slurm, openjd or script
  std::string program;  // absolute, as `home` and `folder` are
  std::string home;     // the folder where relative names begin
  std::string folder;   // of the jobs and the parts
  std::string scene;
  std::vector<std::string> task_options, merge_options;  // a word each, such as --size=64x64
  uint32_t tasks = 1;
  uint32_t samples = 1;                                              // per pixel, of the whole frame
  std::map<std::string, std::optional<std::string>> variables = {};  // of the environment; empty: not set
  std::string inputs = {};                                           // the text of inputs.txt
  std::vector<std::string> frames = {};  // of each task, as --frames takes them; empty: a task is a part of a frame
  std::string stats = {};                // name in the folder, of each frame's statistics; else those of the parts
};

/// The name in the folder of what task K writes: "part.00012.checkpoint".
std::string task_file(const std::string& kind, uint32_t task, const std::string& extension);

/// Why no job can hold these names, and the remedy; empty if one can.
std::string farm_fault(const FarmJobs& jobs);

/// The files' texts by their names, for jobs without a fault. Each name and option is one word of a shell's command, or
/// a string of JSON, and stands nowhere else: not in comments, and not in the lines that Slurm reads by its own rules.
std::map<std::string, std::string> farm_files(const FarmJobs& jobs);

}  // namespace alabaster::cli
