// Jobs of a farm, by names and options of any kind. Each file is read as its reader does: by a lexer of a shell's
// words, written here for the few forms that the files have, and now and then by sh itself; as JSON; as Slurm's
// directives.
#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "delegate/cli/farm_jobs.h"
#include "testenv/fuzz/small_render.h"
#include "testenv/fuzz/structured_input.h"

namespace alabaster::fuzz {
namespace {

using Words = std::vector<std::string>;

std::string name_of(StructuredInput& in) {
  constexpr const char* kPieces[] = {
      "a",    " ",         "'",  "\"",       "$(touch x)", "`touch x`", "{{",
      "}}",   "{{Job.x}}", "\n", "\t",       "\x1b[31m",   "-",         "--help",
      "%j",   "%%",        "\\", ";",        "&",          "|",         ">",
      "*",    "?",         "[",  "~",        "!",          "=",         "#SBATCH --wrap=x",
      "\xff", "\xc2\x9b",  "é",  "\xe2\x80", "$HOME",      "(",         ")"};
  std::string name;
  for (int count = in.choice(6); count > 0; --count)
    name += in.choice(4) == 0 ? in.text(1 + static_cast<size_t>(in.choice(8))) : kPieces[in.choice(std::size(kPieces))];
  std::erase(name, '\0');  // no name and no argument holds it
  return name;
}

bool has_control(const std::string& text) {
  for (size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    if (byte < 0x20 || byte == 0x7f) return true;
    if (byte == 0xc2 && i + 1 < text.size() && (static_cast<unsigned char>(text[i + 1]) & 0xe0) == 0x80) return true;
  }
  return false;
}

/// The words of a line. A character that means something outside of quotes has a \x01 before it: it equals no name.
Words words_of(const std::string& line) {
  Words words;
  std::string word;
  bool begun = false, in_double = false;
  for (size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '\'' && !in_double) {
      const size_t end = line.find('\'', i + 1);
      if (end == std::string::npos) broken("a quote of a job has no end");
      word += line.substr(i + 1, end - i - 1);
      i = end, begun = true;
    } else if (c == '"') {
      in_double = !in_double, begun = true;
    } else if (c == '\\' && !in_double && i + 1 < line.size()) {
      word += line[++i], begun = true;
    } else if (c == ' ' && !in_double) {
      if (begun) words.push_back(word);
      word.clear(), begun = false;
    } else {
      const bool plain = in_double || std::isalnum(static_cast<unsigned char>(c)) || std::strchr("_-./,:=+@%", c);
      word += plain ? std::string(1, c) : std::string("\x01") + c;
      begun = true;
    }
  }
  if (in_double) broken("a double quote of a job has no end");
  if (begun) words.push_back(word);
  return words;
}

Words lines_of(const std::string& text) {
  Words lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);)
    if (!line.starts_with("#")) lines.push_back(line);
  return lines;
}

void expect(const Words& found, const Words& wanted) {
  if (found != wanted) broken("a job's command has other words than it was given");
}

Words joined(Words first, const Words& second, const Words& third) {
  first.insert(first.end(), second.begin(), second.end());
  first.insert(first.end(), third.begin(), third.end());
  return first;
}

void check_scripts(const cli::FarmJobs& jobs, const std::map<std::string, std::string>& files) {
  const Words task = lines_of(files.at("task.sh")), merge = lines_of(files.at("merge.sh"));
  const std::string part = jobs.folder + "/part.", number = "$(printf %05d ";
  const auto of_task = [&](const std::string& kind) { return jobs.folder + "/" + kind + "." + number + "\x01$1)."; };
  expect(words_of(task.at(1)), {"cd", "--", jobs.home});
  const Words inputs = {"--inputs", jobs.folder + "/inputs.txt"};
  const Words run =
      joined({"exec", jobs.program, "render"}, joined(jobs.task_options, inputs, {}),
             {"--quiet", "--running", of_task("task") + "running", "--stats", of_task("stats") + "json", "--samples",
              "$first:$end", "--resume", "--checkpoint", of_task("part") + "checkpoint", "--", jobs.scene});
  expect(words_of(task.at(5)), run);
  expect(words_of(merge.at(1)), {"cd", "--", jobs.home});
  expect(words_of(merge.at(5)), {"set", "--", "$@", part + number + "$k).checkpoint"});
  expect(words_of(merge.at(8)),
         joined({"exec", jobs.program, "merge"}, joined(jobs.merge_options, inputs, {}), {"--", "$@"}));
  if (task.size() != 6 || merge.size() != 9) broken("a job has lines that are not its own");
}

/// What is UTF-8 stays as it is.
void check_farm(const cli::FarmJobs& jobs, const std::string& text) {
  const nlohmann::json farm = nlohmann::json::parse(text, nullptr, false);
  if (farm.is_discarded() || farm.at("tasks") != jobs.tasks || farm.at("samples") != jobs.samples)
    broken("farm.json does not tell the tasks");
  const std::string home = nlohmann::json(jobs.home).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  if (farm.at("home").dump() != home) broken("farm.json has another folder than it was given");
}

void check_slurm(const cli::FarmJobs& jobs, const std::map<std::string, std::string>& files) {
  size_t directives = 0;
  std::istringstream stream(files.at("job.sbatch"));
  for (std::string line; std::getline(stream, line);) directives += line.starts_with("#SBATCH");
  if (directives != 3) broken("Slurm reads a directive of a name");
  const Words job = lines_of(files.at("job.sbatch")), submit = lines_of(files.at("submit.sh"));
  if (job.size() != 1 || submit.size() != 3) broken("a job of Slurm has lines that are not its own");
  expect(words_of(job[0]), {"exec", "sh", jobs.folder + "/task.sh", "$SLURM_ARRAY_TASK_ID"});
  const std::string begin = "job=$(";
  if (!submit[1].starts_with(begin) || !submit[1].ends_with(")")) broken("the submission does not take its number");
  std::string logs = "--output=";
  for (const char c : jobs.folder) logs += c == '%' ? "%%" : std::string(1, c);
  expect(words_of(submit[1].substr(begin.size(), submit[1].size() - begin.size() - 1)),
         {"sbatch", "--parsable", logs + "/task_%a.log", "$@", "--", jobs.folder + "/job.sbatch"});
  expect(words_of(submit[2]),
         {"sbatch", "--dependency=afterok:${job%%;*}", "--kill-on-invalid-dep=yes", "--job-name=alabaster-merge",
          logs + "/merge.log", "$@", "--", jobs.folder + "/merge.sh"});
}

void check_template(const cli::FarmJobs& jobs, const std::string& text) {
  const nlohmann::json job = nlohmann::json::parse(text, nullptr, false);
  if (job.is_discarded()) broken("a template is not JSON");
  const auto words = [&](size_t step) {
    return job.at("steps").at(step).at("script").at("actions").at("onRun").at("args");
  };
  if (words(0) != nlohmann::json({jobs.folder + "/task.sh", "{{Task.Param.Part}}"}) ||
      words(1) != nlohmann::json({jobs.folder + "/merge.sh"}))
    broken("a template has other words than it was given");
  const size_t first = text.find("{{");
  if (text.find("{{", first + 1) != std::string::npos) broken("a name is a variable of a template");
}

/// Lets sh read the file without running anything.
void check_syntax(const std::string& text) {
  const std::string file = scratch_file("job.sh", {reinterpret_cast<const uint8_t*>(text.data()), text.size()});
  Words words{"sh", "-n", file};
  char* arguments[] = {words[0].data(), words[1].data(), words[2].data(), nullptr};
  pid_t child = 0;
  int status = 0;
  if (posix_spawn(&child, "/bin/sh", nullptr, nullptr, arguments, environ) != 0) return;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (status != 0) broken("sh cannot read a job");
}

}  // namespace

void run_job(Bytes input) {
  StructuredInput in(input);
  cli::FarmJobs jobs;
  constexpr const char* kEngines[] = {"script", "slurm", "openjd"};
  jobs.engine = kEngines[in.choice(3)];
  jobs.tasks = 1 + static_cast<uint32_t>(in.choice(5));
  jobs.samples = jobs.tasks + static_cast<uint32_t>(in.choice(200));
  jobs.program = "/" + name_of(in);
  jobs.home = "/" + name_of(in);
  jobs.folder = "/" + name_of(in);
  jobs.scene = name_of(in);
  for (int count = in.choice(3); count > 0; --count) jobs.task_options.push_back("--set=" + name_of(in));
  for (int count = in.choice(3); count > 0; --count) jobs.merge_options.push_back("--output=" + name_of(in));
  Words names = joined({jobs.program, jobs.home, jobs.folder, jobs.scene}, jobs.task_options, jobs.merge_options);
  const std::string fault = cli::farm_fault(jobs);
  if (fault.empty() && std::any_of(names.begin(), names.end(), has_control)) broken("a control character is in a job");
  if (has_control(fault)) broken("a fault of a job has control characters");
  if (!fault.empty()) return;
  const std::map<std::string, std::string> files = cli::farm_files(jobs);
  check_scripts(jobs, files);
  check_farm(jobs, files.at("farm.json"));
  if (jobs.engine == std::string("slurm"))
    check_slurm(jobs, files);
  else if (jobs.engine == std::string("openjd"))
    check_template(jobs, files.at("template.json"));
  else
    for (uint32_t k = 0; k < jobs.tasks; ++k)
      expect(words_of(lines_of(files.at("tasks.txt")).at(k)), {"sh", jobs.folder + "/task.sh", std::to_string(k)});
  static int since = 0;
  if (since++ % 50 == 0)
    for (const auto& [name, text] : files)
      if (!name.ends_with(".json")) check_syntax(text);
}

}  // namespace alabaster::fuzz
