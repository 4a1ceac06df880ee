// Names in jobs: each stays one word of one command, whatever it holds, or is refused. The files are run as engines run
// them, with programs that write down what they are given.
#include "delegate/cli/farm_jobs.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>

namespace alabaster::cli {
namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

/// Names that a shell, Slurm or a template would read as more than a name.
const Words kHostile = {"plain",
                        "two words",
                        " ",
                        "it's",
                        "\"quoted\"",
                        "$(touch PWNED)",
                        "`touch PWNED`",
                        "; touch PWNED;",
                        "& touch PWNED &",
                        "| touch PWNED",
                        "> PWNED",
                        "' ; touch PWNED ; '",
                        "$HOME",
                        "*",
                        "~",
                        "!!",
                        "#SBATCH --wrap=touch",
                        "# ",
                        "-dash",
                        "--help",
                        "%j_%a_%%_%5A",
                        "back\\slash\\",
                        "{a,b}",
                        "[x]",
                        "\xff\xfe no text",
                        "\xc3\xa9t\xc3\xa9",
                        "=",
                        "a=b"};

class FarmJobFiles : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(folder_ / "bin");
    // Appends its words, each with a NUL, and runs the script that it was given last as Slurm would.
    program("bin/recorder", "printf '%s\\0' \"$@\" >>\"$RECORD\"\nprintf '\\n' >>\"$RECORD\"\n");
    program("bin/sbatch",
            "printf '%s\\0' sbatch \"$@\" >>\"$RECORD\"\nprintf '\\n' >>\"$RECORD\"\necho '12;cluster'\n");
  }
  void TearDown() override { fs::remove_all(folder_); }

  void program(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << "#!/bin/sh\n" << text;
    fs::permissions(folder_ / name, fs::perms::owner_all);
  }
  FarmJobs jobs(const std::string& engine, const std::string& name) const {
    FarmJobs j;
    j.engine = engine;
    j.program = folder_ / "bin/recorder";
    j.home = folder_ / ("home " + name);
    j.folder = folder_ / ("farm " + name);
    j.scene = name + ".glb";
    j.task_options = {"--set=" + name, "--denoise"};
    j.merge_options = {"--output=" + name + ".exr"};
    j.tasks = 3, j.samples = 10;
    return j;
  }
  void write(const FarmJobs& j) const {
    fs::create_directories(j.home);
    fs::create_directories(j.folder);
    for (const auto& [name, text] : farm_files(j)) std::ofstream(fs::path(j.folder) / name, std::ios::binary) << text;
  }
  /// Runs `command`, whose "$1" is `argument`, and returns the words of each call of a program.
  std::vector<Words> calls(const std::string& command, const std::string& argument) const {
    const fs::path record = folder_ / "record";
    fs::remove(record);
    const pid_t child = fork();
    if (child == 0) {
      if (chdir(folder_.c_str()) != 0 || !freopen("/dev/null", "w", stdout)) _exit(99);
      setenv("RECORD", record.c_str(), 1);
      setenv("PATH", (folder_.string() + "/bin:/usr/bin:/bin").c_str(), 1);
      setenv("SLURM_ARRAY_TASK_ID", "1", 1);
      execl("/bin/sh", "sh", "-c", command.c_str(), "sh", argument.c_str(), nullptr);
      _exit(99);
    }
    int status = -1;
    waitpid(child, &status, 0);
    EXPECT_EQ(status, 0) << command << ": " << argument;
    EXPECT_FALSE(fs::exists(folder_ / "PWNED")) << argument;
    std::ifstream file(record, std::ios::binary);
    std::vector<Words> all(1);
    std::string word;
    for (char c = 0; file.get(c);) {
      if (c == '\n')
        all.emplace_back();
      else if (c == 0)
        all.back().push_back(std::exchange(word, ""));
      else
        word += c;
    }
    all.pop_back();
    return all;
  }
  static std::string part(const FarmJobs& j, int k) {
    return j.folder + "/part.0000" + std::to_string(k) + ".checkpoint";
  }

  const fs::path folder_ = fs::temp_directory_path() / ("alabaster_farm_jobs_" + std::to_string(getpid()));
};

// promise: farm.names.data
TEST_F(FarmJobFiles, ATaskAndTheMergeGetTheNamesThatWereGiven) {
  for (const std::string& name : kHostile) {
    const FarmJobs j = jobs("script", name);
    ASSERT_EQ(farm_fault(j), "") << name;
    write(j);
    EXPECT_EQ(
        calls("sh \"$1\" 1", j.folder + "/task.sh"),
        std::vector<Words>({{"render", "--set=" + name, "--denoise", "--inputs", j.folder + "/inputs.txt", "--quiet",
                             "--running", j.folder + "/task.00001.running", "--stats", j.folder + "/stats.00001.json",
                             "--samples", "3:6", "--resume", "--checkpoint", part(j, 1), "--", name + ".glb"}}));
    EXPECT_EQ(calls("sh \"$1\"", j.folder + "/merge.sh"),
              std::vector<Words>({{"merge", "--output=" + name + ".exr", "--inputs", j.folder + "/inputs.txt", "--",
                                   part(j, 0), part(j, 1), part(j, 2)}}));
    // As an engine does that takes a line for a command.
    EXPECT_EQ(
        calls("while IFS= read -r line; do sh -c \"$line\" || exit 1; done <\"$1\"", j.folder + "/tasks.txt").size(),
        3u);
  }
}

TEST_F(FarmJobFiles, SlurmGetsNoNameInItsOwnLines) {
  for (const std::string& name : kHostile) {
    const FarmJobs j = jobs("slurm", name);
    if (name.find('\\') != std::string::npos) {
      EXPECT_NE(farm_fault(j).find("has a backslash"), std::string::npos) << farm_fault(j);
      continue;
    }
    ASSERT_EQ(farm_fault(j), "") << name;
    write(j);
    const std::string logs = std::regex_replace("--output=" + j.folder, std::regex("%"), "%%");
    EXPECT_EQ(
        calls("sh \"$1\" --partition 'a b'", j.folder + "/submit.sh"),
        std::vector<Words>(
            {{"sbatch", "--parsable", logs + "/task_%a.log", "--partition", "a b", "--", j.folder + "/job.sbatch"},
             {"sbatch", "--dependency=afterok:12", "--kill-on-invalid-dep=yes", "--job-name=alabaster-merge",
              logs + "/merge.log", "--partition", "a b", "--", j.folder + "/merge.sh"}}));
    const std::vector<Words> task = calls("sh \"$1\"", j.folder + "/job.sbatch");
    ASSERT_EQ(task.size(), 1u);
    EXPECT_EQ(task[0].back(), name + ".glb");
    std::ifstream file(j.folder + "/job.sbatch");
    Words directives;
    for (std::string line; std::getline(file, line);)
      if (line.starts_with("#SBATCH")) directives.push_back(line);
    EXPECT_EQ(directives, Words({"#SBATCH --job-name=alabaster", "#SBATCH --array=0-2", "#SBATCH --requeue"}));
  }
}

TEST_F(FarmJobFiles, ATemplateHoldsTheFolderAsTextOrRefusesIt) {
  for (const std::string& name : kHostile) {
    const FarmJobs j = jobs("openjd", name);
    if (name.starts_with("\xff")) {
      EXPECT_NE(farm_fault(j).find("not UTF-8"), std::string::npos) << farm_fault(j);
      continue;
    }
    ASSERT_EQ(farm_fault(j), "") << name;
    const std::string text = farm_files(j).at("template.json");
    EXPECT_TRUE(std::all_of(text.begin(), text.end(), [](unsigned char c) { return c < 128; })) << text;
    const auto steps = nlohmann::json::parse(text).at("steps");
    const auto words = [](const nlohmann::json& step) {
      return step.at("script").at("actions").at("onRun").at("args");
    };
    EXPECT_EQ(words(steps[0]), nlohmann::json({j.folder + "/task.sh", "{{Task.Param.Part}}"}));
    EXPECT_EQ(words(steps[1]), nlohmann::json({j.folder + "/merge.sh"}));
  }
  for (const char* name : {"{{Task.Param.Part}}", "a{{", "}}b", "{{{"}) {
    const std::string fault = farm_fault(jobs("openjd", name));
    EXPECT_NE(fault.find("a variable in Open Job Description; choose another folder"), std::string::npos) << fault;
    EXPECT_EQ(farm_fault(jobs("slurm", name)), "") << "the others have no templates";
  }
}

// promise: farm.names.refused
TEST_F(FarmJobFiles, ControlCharactersAreRefusedWhereverTheyStand) {
  for (const std::string engine : {"script", "slurm", "openjd"})
    for (const std::string name : {"a\ntouch PWNED\n#", "a\rb", "tab\t", "\x1b[31m", "\x7f",
                                   "\xc2\x9b"
                                   "31m",
                                   "\x01"}) {
      const FarmJobs sound = jobs(engine, "plain");
      const auto refused = [&](auto change, const char* said) {
        FarmJobs j = sound;
        change(j);
        const std::string fault = farm_fault(j);
        EXPECT_NE(fault.find(said), std::string::npos) << fault;
        EXPECT_NE(fault.find("rename"), std::string::npos) << fault;
        EXPECT_TRUE(std::all_of(fault.begin(), fault.end(), [](unsigned char c) { return c >= 32 && c != 127; }));
      };
      refused([&](FarmJobs& j) { j.scene = name; }, "scene");
      refused([&](FarmJobs& j) { j.folder += name; }, "folder for the jobs");
      refused([&](FarmJobs& j) { j.home += name; }, "current folder");
      refused([&](FarmJobs& j) { j.program += name; }, "program");
      refused([&](FarmJobs& j) { j.task_options[0] += name; }, "option");
      refused([&](FarmJobs& j) { j.merge_options[0] += name; }, "option");
      EXPECT_EQ(farm_fault(sound), "");
    }
}

}  // namespace
}  // namespace alabaster::cli
