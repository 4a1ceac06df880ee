// Frames in parts on several machines: the jobs that are written, run as an engine would run them.
#include <OpenImageIO/imageio.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "testenv/support/oidn.h"
#include "testenv/unit/delegate/cli/run_program.h"
#include "testenv/unit/delegate/description/scene_fixture.h"

namespace alabaster::cli {
namespace {

using nlohmann::json;

class Farm : public hd::description::SceneFiles {
 protected:
  Outcome run(const std::vector<std::string>& arguments) const { return run_program(folder_, arguments); }
  int shell(const std::string& line) const {
    return std::system(("cd " + folder_.string() + " && " + line + " >shell.txt 2>&1").c_str());
  }
  std::string read(const std::string& name) const {
    std::ifstream in(folder_ / name);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  /// What `alabaster farm status` tells of a task, and with what exit code.
  json task_of(const std::string& folder, size_t task, int code) const {
    const Outcome told = run({"farm", "status", folder, "--json"});
    EXPECT_EQ(told.code, code) << told.out << told.err;
    const json all = json::parse(told.out, nullptr, false);
    EXPECT_FALSE(all.is_discarded()) << told.out << told.err;
    EXPECT_EQ(all.value("exitCode", -1), code);
    return all.is_discarded() ? json() : all.at("tasks").at(task);
  }
  std::vector<float> pixels(const std::string& name) const {
    const auto image = OIIO::ImageInput::open(folder_ / name);
    EXPECT_TRUE(image) << name;
    if (!image) return {};
    const OIIO::ImageSpec& spec = image->spec();
    std::vector<float> all(static_cast<size_t>(spec.width) * static_cast<size_t>(spec.height) *
                           static_cast<size_t>(spec.nchannels));
    EXPECT_TRUE(image->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, all.data()));
    return all;
  }
};

// promise: farm.engine.script, farm.files.merge, farm.files.task
TEST_F(Farm, TheMergedFrameIsThatOfOneMachineThoughATaskIsLost) {
  const std::vector<std::string> frame{"--size", "20x12", "--set", "samples=10", "--aov", "depth", "--set", "seed=7"};
  std::vector<std::string> alone{"render", "patch.gltf", "-o", "alone.exr"},
      farm{"farm", "patch.gltf", "-o", "a b.exr"};
  alone.insert(alone.end(), frame.begin(), frame.end());
  farm.insert(farm.end(), frame.begin(), frame.end());
  farm.insert(farm.end(), {"--tasks", "3"});
  ASSERT_EQ(run(alone).code, 0);
  const Outcome wrote = run(farm);
  ASSERT_EQ(wrote.code, 0) << wrote.err;
  std::istringstream tasks(read("patch_farm/tasks.txt"));
  std::vector<std::string> lines;
  for (std::string line; std::getline(tasks, line);) lines.push_back(line);
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_EQ(shell(lines[0]), 0) << read("shell.txt");
  EXPECT_EQ(shell(lines[2]), 0) << read("shell.txt");
  EXPECT_NE(shell("sh patch_farm/merge.sh"), 0) << "the second part is missing";
  EXPECT_NE(read("shell.txt").find("parts missing: 1 of 3. First run its task: sh "), std::string::npos)
      << read("shell.txt");
  EXPECT_EQ(shell(lines[1]), 0) << read("shell.txt");
  std::filesystem::rename(folder_ / "patch_farm/part.00002.checkpoint", folder_ / "lost");
  EXPECT_NE(shell("sh patch_farm/merge.sh"), 0) << "the last part is missing";
  std::filesystem::rename(folder_ / "lost", folder_ / "patch_farm/part.00002.checkpoint");
  EXPECT_EQ(run(farm).code, 2) << "the folder holds a farm";
  EXPECT_EQ(shell(lines[1]), 0) << "run again: " << read("shell.txt");
  EXPECT_EQ(shell("sh patch_farm/merge.sh"), 0) << read("shell.txt");
  EXPECT_EQ(pixels("a b.exr"), pixels("alone.exr"));
}

// An engine ends the process that it started, and the merge tells what --keep-going left out.
TEST_F(Farm, ATaskIsItsRenderAlsoWithKeepGoing) {
  write("scene.json", R"({"models": [{"file": "patch.gltf"}], "settings": {"resolution": [64, 48]}, "materials":
    [{"match": "skin", "set": {"baseColor": {"file": "absent.png"}}}]})");
  const auto farm = [&](const std::string& spp, const std::string& folder) {
    return run({"farm", "scene.json", "-o", "a.exr", "--tasks", "1", "--keep-going", "--spp", spp, "--folder", folder});
  };
  ASSERT_EQ(farm("1000000", "long").code, 0);
  const std::string checkpoint = folder_ / "long/part.00000.checkpoint";
  const pid_t task = fork();
  if (task == 0) {
    const std::string script = folder_ / "long/task.sh";
    execl("/bin/sh", "sh", script.c_str(), "0", nullptr);
    _exit(99);
  }
  // The shell alone takes no time, and loading this scene little.
  const auto cpu_seconds = [&] {
    std::ifstream stat("/proc/" + std::to_string(task) + "/stat");
    std::string field;
    for (int i = 0; i < 13; ++i) stat >> field;
    double user = 0;
    stat >> user;
    return user / static_cast<double>(sysconf(_SC_CLK_TCK));
  };
  for (int i = 0; i < 600 && cpu_seconds() < 3; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(100));
  ASSERT_EQ(kill(task, SIGTERM), 0);
  int status = 0;
  ASSERT_EQ(waitpid(task, &status, 0), task);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 130);
  EXPECT_TRUE(std::filesystem::exists(checkpoint)) << "the render ended, and saved its samples";
  const json stopped = task_of("long", 0, 4);
  EXPECT_EQ(stopped.at("state"), "failed");
  EXPECT_EQ(stopped.at("exitCode"), 130);
  EXPECT_EQ(stopped.at("reason"), "it was told to end, by a signal");
  EXPECT_GT(stopped.at("samplesSaved"), 0);
  EXPECT_GT(stopped.at("noise"), 0);
  ASSERT_EQ(farm("2", "short").code, 0);
  EXPECT_EQ(shell("sh short/task.sh 0"), 0) << read("shell.txt");
  const json degraded = task_of("short", 0, 6);
  EXPECT_EQ(degraded.at("state"), "degraded");
  EXPECT_NE(degraded.at("reason").get<std::string>().find("absent.png"), std::string::npos) << degraded;
  EXPECT_EQ(shell("sh short/merge.sh") >> 8, 6) << read("shell.txt");
}

// A task whose frame fails leaves its statistics; run again it renders only what is missing.
// promise: farm.frames, farm.frames.again, farm.force, pipeline.stats.host, pipeline.stats.reason
TEST_F(Farm, FramesOfTasksAreThoseOfOneMachine) {
  write("scene.json", R"({"models": [{"file": "patch.gltf"}], "settings": {"samples": 2, "resolution": [16, 12]},
    "camera": {"lookAt": {"eye": [0, 0, 3], "target": [0, 0, 0]}}})");
  ASSERT_EQ(run({"render", "scene.json", "-o", "alone.####.exr", "--frames", "1:4,6"}).code, 0);
  const std::vector<std::string> farm{"farm", "scene.json", "-o", "a b.####.exr", "--frames", "1:4,6", "--tasks", "2"};
  const Outcome wrote = run(farm);
  ASSERT_EQ(wrote.code, 0) << wrote.err;
  EXPECT_FALSE(std::filesystem::exists(folder_ / "scene_farm/merge.sh"));
  EXPECT_EQ(read("scene_farm/task.sh").find("--samples"), std::string::npos);
  EXPECT_EQ(task_of("scene_farm", 0, 1).at("state"), "waiting");
  std::filesystem::create_directory(folder_ / "a b.0002.exr");
  EXPECT_EQ(shell("sh scene_farm/task.sh 0") >> 8, 5) << read("shell.txt");
  const std::string reason = "a b.0002.exr: a folder has this name; choose another name";
  const json stats = json::parse(read("scene_farm/stats.0002.json"));
  EXPECT_EQ(stats.at("exitCode"), 5);
  EXPECT_EQ(stats.at("reason"), reason);
  const json failed = task_of("scene_farm", 0, 4);
  EXPECT_EQ(failed.at("state"), "failed");
  EXPECT_EQ(failed.at("reason"), reason);
  EXPECT_EQ(failed.at("frames").at(0).at("state"), "done");
  EXPECT_EQ(failed.at("frames").at(1).at("exitCode"), 5);
  EXPECT_NE(run({"farm", "status", "scene_farm"}).out.find("exit code 5: " + reason + "\n"), std::string::npos);
  std::filesystem::remove(folder_ / "a b.0002.exr");
  const auto first = std::filesystem::last_write_time(folder_ / "a b.0001.exr");
  for (const char* task : {"0", "1"})
    EXPECT_EQ(shell(std::string("sh scene_farm/task.sh ") + task), 0) << read("shell.txt");
  EXPECT_EQ(std::filesystem::last_write_time(folder_ / "a b.0001.exr"), first) << "a frame that is whole stays";
  for (const std::string frame : {"0001", "0002", "0003", "0004", "0006"})
    EXPECT_EQ(pixels("a b." + frame + ".exr"), pixels("alone." + frame + ".exr")) << frame;
  const json done = task_of("scene_farm", 0, 0);
  EXPECT_EQ(done.at("state"), "done") << done;
  EXPECT_GT(done.at("seconds"), 0);
  EXPECT_GT(done.at("noise"), 0);
  EXPECT_FALSE(done.at("host").get<std::string>().empty());
  EXPECT_EQ(shell("sh scene_farm/task.sh 2") >> 8, 2);
  EXPECT_EQ(run(farm).code, 2) << "the folder holds a farm";
  std::vector<std::string> again = farm;
  again.push_back("--force");
  EXPECT_EQ(run(again).code, 0);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "scene_farm/stats.0002.json"));
}

// A task that the kernel ends says nothing, so its mark stays; run again, it goes on.
// promise: farm.files.farm, farm.status, farm.status.code, farm.status.running, pipeline.exit.to_do
TEST_F(Farm, StatusTellsTasksThatWereKilledFromThoseThatRunAndThoseThatNeverBegan) {
  ASSERT_EQ(run({"farm", "patch.gltf", "-o", "a.exr", "--size", "64x48", "--spp", "1000000", "--tasks", "3"}).code, 0);
  EXPECT_EQ(task_of("patch_farm", 1, 1),
            json({{"task", 1}, {"state", "waiting"}, {"samples", {333333, 666666}}, {"samplesSaved", 0}}));
  const std::string script = folder_ / "patch_farm/task.sh", mark = folder_ / "patch_farm/task.00001.running";
  const pid_t task = fork();
  if (task == 0) {
    execl("/bin/sh", "sh", script.c_str(), "1", nullptr);
    _exit(99);
  }
  for (int i = 0; i < 600 && read("patch_farm/task.00001.running").empty(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  const std::string running = read("patch_farm/task.00001.running");
  // A lock tells of this machine's tasks, however long ago they gave a sign.
  const auto sign_was = [&](int seconds_ago) {
    const auto now = std::filesystem::file_time_type::clock::now();
    std::filesystem::last_write_time(mark, now - std::chrono::seconds(seconds_ago));
  };
  sign_was(3600);
  const json lives = task_of("patch_farm", 1, 1);
  EXPECT_EQ(lives.at("state"), "running") << running;
  EXPECT_EQ(lives.at("host"), json::parse(running).at("host"));
  ASSERT_EQ(kill(task, SIGKILL), 0);
  int status = 0;
  ASSERT_EQ(waitpid(task, &status, 0), task);
  sign_was(0);
  const json lost = task_of("patch_farm", 1, 4);
  EXPECT_EQ(lost.at("state"), "lost");
  EXPECT_EQ(lost.at("reason"), "it ended without a word: it was killed, or its machine failed");
  EXPECT_EQ(task_of("patch_farm", 0, 4).at("state"), "waiting");
  // The same of another machine, of which the time of its last sign is all that is known.
  json other = json::parse(running);
  other["boot"] = "another", other["host"] = "node7";
  write("patch_farm/task.00001.running", other.dump());
  EXPECT_EQ(task_of("patch_farm", 1, 1).at("state"), "running");
  sign_was(600);
  const json silent = task_of("patch_farm", 1, 4);
  EXPECT_EQ(silent.at("state"), "lost");
  EXPECT_NE(silent.at("reason").get<std::string>().find("it has given no sign for 10:0"), std::string::npos) << silent;
  EXPECT_NE(run({"farm", "status", "patch_farm"}).out.find("3 tasks: 0 done, 2 waiting, 1 lost\n"), std::string::npos);
}

// While the scene is read there is nothing to save, and no statistics are written.
// promise: farm.status
TEST_F(Farm, ATaskThatIsToldToEndHasFailedAtWhateverItWasDoing) {
  ASSERT_EQ(run({"farm", "patch.gltf", "-o", "a.exr", "--size", "64x48", "--spp", "1000000", "--tasks", "3"}).code, 0);
  for (const int wait : {0, 0, 20, 1500}) {
    const std::string script = folder_ / "patch_farm/task.sh", mark = "patch_farm/task.00001.running";
    std::filesystem::remove(folder_ / mark);
    const pid_t task = fork();
    if (task == 0) {
      execl("/bin/sh", "sh", script.c_str(), "1", nullptr);
      _exit(99);
    }
    for (int i = 0; i < 60000 && read(mark).empty(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    std::this_thread::sleep_for(std::chrono::milliseconds(wait));
    ASSERT_EQ(kill(task, SIGTERM), 0);
    int status = 0;
    ASSERT_EQ(waitpid(task, &status, 0), task);
    const json ended = task_of("patch_farm", 1, 4);
    EXPECT_EQ(ended.at("state"), "failed") << wait << " ms";
    EXPECT_EQ(ended.value("exitCode", 0), 130) << wait << " ms";
    EXPECT_EQ(ended.at("reason"), "it was told to end, by a signal") << wait << " ms";
  }
}

// promise: farm.status, farm.status.code
TEST_F(Farm, StatusOfPartsHasTheNoiseOfTheirSum) {
  const std::vector<std::string> frame{"--size", "48x32", "--dome", "0.2", "--set", "samples=96"};
  std::vector<std::string> farm{"farm", "patch.gltf", "-o", "a.exr", "--tasks", "3"},
      whole{"render", "patch.gltf", "-o", "b.exr", "--stats", "s.json"};
  farm.insert(farm.end(), frame.begin(), frame.end());
  whole.insert(whole.end(), frame.begin(), frame.end());
  ASSERT_EQ(run(farm).code, 0);
  for (const char* task : {"0", "1", "2"})
    EXPECT_EQ(shell(std::string("sh patch_farm/task.sh ") + task), 0) << read("shell.txt");
  const json part = task_of("patch_farm", 2, 0);
  EXPECT_EQ(part.at("state"), "done");
  EXPECT_EQ(part.at("samplesSaved"), 32);
  ASSERT_EQ(run(whole).code, 0);
  const double noise = json::parse(run({"farm", "status", "patch_farm", "--json"}).out).at("noise");
  EXPECT_NEAR(noise / json::parse(read("s.json")).at("error").at("relativeRmse").get<double>(), 1, 0.3);
  EXPECT_NEAR(noise / part.at("noise").get<double>(), 1 / std::sqrt(3.0), 0.15);
  EXPECT_EQ(shell("sh patch_farm/task.sh 2"), 0) << "run again, a whole part keeps its time";
  EXPECT_GE(task_of("patch_farm", 2, 0).at("seconds"), part.at("seconds"));
  std::filesystem::remove(folder_ / "patch_farm/part.00002.checkpoint");
  EXPECT_EQ(task_of("patch_farm", 2, 1).at("state"), "waiting");
  write("patch_farm/part.00002.checkpoint", "x");
  EXPECT_EQ(task_of("patch_farm", 2, 4).at("state"), "failed");
  EXPECT_EQ(run({"farm", "status", "."}).code, 3);
  const Outcome alone = run({"farm", "status"});
  EXPECT_EQ(alone.code, 2);
  EXPECT_NE(alone.err.find("FOLDER is required. For example:\n  alabaster farm status scene_farm\n"), std::string::npos)
      << alone.err;
}

// Each task makes its mark without a word of whoever looks; what is no mark is not written over.
TEST_F(Farm, AMarkReplacesNoOtherFile) {
  write("mine.txt", "mine");
  const Outcome refused =
      run({"render", "patch.gltf", "-o", "a.exr", "--size", "8x6", "--spp", "1", "--running", "mine.txt"});
  EXPECT_EQ(refused.code, 5) << refused.err;
  EXPECT_EQ(read("mine.txt"), "mine");
  ASSERT_EQ(run({"render", "patch.gltf", "-o", "a.exr", "--size", "8x6", "--spp", "1", "--running", "mark"}).code, 0);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "mark"));
}

TEST_F(Farm, AJobOfFramesHasNoMerge) {
  write("scene.json", R"({"models": [{"file": "patch.gltf"}], "settings": {"samples": 2, "resolution": [16, 12]},
    "camera": {"lookAt": {"eye": [0, 0, 3], "target": [0, 0, 0]}}})");
  const auto farm = [&](const char* engine) {
    return run({"farm", "scene.json", "-o", "a.####.exr", "--frames", "1:3", "--engine", engine, "--folder", engine});
  };
  ASSERT_EQ(farm("openjd").code, 0);
  const auto job = nlohmann::json::parse(read("openjd/template.json"));
  ASSERT_EQ(job.at("steps").size(), 1u);
  EXPECT_EQ(job["steps"][0].at("parameterSpace").at("taskParameterDefinitions").at(0).at("range"), "0-2");
  ASSERT_EQ(farm("slurm").code, 0);
  EXPECT_NE(read("slurm/job.sbatch").find("#SBATCH --array=0-2\n"), std::string::npos);
  for (const char* name : {"task.sh", "submit.sh", "job.sbatch"})
    EXPECT_EQ(shell(std::string("sh -n slurm/") + name), 0) << name;
  EXPECT_EQ(read("slurm/submit.sh").find("merge"), std::string::npos);
}

// promise: farm.engine.slurm
TEST_F(Farm, JobsForSlurmAreAnArrayAndAMerge) {
  ASSERT_EQ(
      run({"farm", "patch.gltf", "-o", "a.exr", "--spp", "8", "--tasks", "4", "--engine", "slurm", "--folder", "jobs"})
          .code,
      0);
  const std::string job = read("jobs/job.sbatch");
  EXPECT_NE(job.find("#SBATCH --array=0-3\n"), std::string::npos) << job;
  for (const char* name : {"task.sh", "merge.sh", "submit.sh", "job.sbatch"})
    EXPECT_EQ(shell(std::string("sh -n jobs/") + name), 0) << name;
}

// Specification jobtemplate-2023-09 of Open Job Description: a step with a task for each value of its parameter, and
// one that depends on it.
// promise: farm.engine.openjd
TEST_F(Farm, AnOpenJobDescriptionHasTheTasksAndAMergeThatWaitsForThem) {
  const std::vector<std::string> words{"farm",  "patch.gltf", "-o",      "a b.exr", "--size",   "20x12",
                                       "--spp", "8",          "--tasks", "4",       "--engine", "openjd"};
  const Outcome wrote = run(words);
  ASSERT_EQ(wrote.code, 0) << wrote.err;
  const auto job = nlohmann::json::parse(read("patch_farm/template.json"));
  EXPECT_EQ(job.at("specificationVersion"), "jobtemplate-2023-09");
  EXPECT_EQ(job.at("name"), "alabaster");
  ASSERT_EQ(job.at("steps").size(), 2u);
  const auto &render = job["steps"][0], &merge = job["steps"][1];
  const auto& part = render.at("parameterSpace").at("taskParameterDefinitions").at(0);
  EXPECT_EQ(part, nlohmann::json({{"name", "Part"}, {"type", "INT"}, {"range", "0-3"}}));
  EXPECT_EQ(merge.at("dependencies").at(0).at("dependsOn"), render.at("name"));
  const auto line = [](const nlohmann::json& step, const std::string& task) {
    const auto& action = step.at("script").at("actions").at("onRun");
    std::string all = action.at("command");
    for (const std::string word : action.at("args")) all += " '" + (word == "{{Task.Param.Part}}" ? task : word) + "'";
    return all;
  };
  for (const char* task : {"0", "1", "2", "3"}) EXPECT_EQ(shell(line(render, task)), 0) << read("shell.txt");
  EXPECT_EQ(shell(line(merge, "")), 0) << read("shell.txt");
  EXPECT_FALSE(pixels("a b.exr").empty());
  std::filesystem::create_directory(folder_ / "{{x}}");
  std::vector<std::string> refused = words;
  refused.insert(refused.end(), {"--folder", "{{x}}"});
  EXPECT_EQ(run(refused).code, 2) << "braces begin a variable";
}

// A configuration whose view halves or doubles, by a LUT that a variable chooses.
class FarmInputs : public Farm {
 protected:
  void SetUp() override {
    Farm::SetUp();
    write("show.ocio", R"(ocio_profile_version: 2
environment: {SHOT: bright}
search_path: luts/$SHOT
roles: {default: raw, scene_linear: lin}
displays:
  Screen:
    - !<View> {name: Graded, colorspace: graded}
    - !<View> {name: Plain, colorspace: lin}
colorspaces:
  - !<ColorSpace> {name: raw, isdata: true}
  - !<ColorSpace> {name: lin}
  - !<ColorSpace> {name: graded, from_scene_reference: !<FileTransform> {src: grade.cc}}
)");
    for (const auto& [shot, slope] : {std::pair("bright", "2 2 2"), std::pair("dark", "0.5 0.5 0.5")}) {
      std::filesystem::create_directories(folder_ / "luts" / shot);
      write(std::string("luts/") + shot + "/grade.cc",
            std::string("<ColorCorrection id=\"x\"><SOPNode><Slope>") + slope +
                "</Slope><Offset>0 0 0</Offset><Power>1 1 1</Power></SOPNode></ColorCorrection>");
    }
  }
  /// The exit code of the program with these variables and arguments; its messages are in shell.txt.
  int with(const std::string& variables, const std::string& arguments) const {
    return shell("env -u OCIO " + variables + " " + testing::kProgram + " " + arguments);
  }
  static constexpr const char* kFrame = "--size 12x8 --spp 4 --dome 0.2";
  void write_farm(const std::string& variables) const {
    ASSERT_EQ(with(variables, std::string("farm patch.gltf -o farm.png --tasks 2 ") + kFrame), 0) << read("shell.txt");
  }
  void expect_refused(const std::string& command, const std::string& where, const std::string& remedy) const {
    EXPECT_EQ(shell(command) >> 8, 3) << command;
    EXPECT_NE(read("shell.txt").find(where), std::string::npos) << read("shell.txt");
    EXPECT_NE(read("shell.txt").find(remedy), std::string::npos) << read("shell.txt");
    EXPECT_FALSE(std::filesystem::exists(folder_ / "patch_farm/part.00000.checkpoint")) << command;
  }
};

// promise: farm.colors
TEST_F(FarmInputs, TheConfigurationOfTheEnvironmentIsThatOfEveryMachine) {
  ASSERT_EQ(with("OCIO=show.ocio SHOT=dark", std::string("render patch.gltf -o alone.png ") + kFrame), 0)
      << read("shell.txt");
  ASSERT_EQ(with("", std::string("render patch.gltf -o plain.png ") + kFrame), 0) << read("shell.txt");
  ASSERT_NE(pixels("alone.png"), pixels("plain.png"));
  write_farm("OCIO=show.ocio SHOT=dark");
  for (const char* job : {"task.sh 0", "task.sh 1", "merge.sh"})
    EXPECT_EQ(shell(std::string("env -u OCIO SHOT=bright OCIO_ACTIVE_VIEWS=Plain sh patch_farm/") + job), 0)
        << read("shell.txt");
  EXPECT_EQ(pixels("farm.png"), pixels("alone.png"));
}

TEST_F(FarmInputs, AMachineWithoutAConfigurationOfItsOwnTakesTheBuiltInOne) {
  ASSERT_EQ(with("", std::string("render patch.gltf -o plain.png ") + kFrame), 0) << read("shell.txt");
  write_farm("");
  for (const char* job : {"task.sh 0", "task.sh 1", "merge.sh"})
    EXPECT_EQ(shell(std::string("OCIO=show.ocio sh patch_farm/") + job), 0) << read("shell.txt");
  EXPECT_EQ(pixels("farm.png"), pixels("plain.png"));
}

// The programs of a job need those of its machine, which may have its users elsewhere.
TEST_F(FarmInputs, VariablesOfTheLoginStayThoseOfTheMachine) {
  std::string config = read("show.ocio");
  config.replace(config.find("luts/$SHOT"), 10, "luts/$SHOT:${HOME}/luts:$PATH");
  write("show.ocio", config);
  write_farm("OCIO=show.ocio SHOT=dark");
  const std::string task = read("patch_farm/task.sh");
  EXPECT_NE(task.find("\nexport SHOT=dark\n"), std::string::npos) << task;
  for (const char* name : {"HOME", "PATH"})
    EXPECT_EQ(task.find("export " + std::string(name)), std::string::npos) << task;
  EXPECT_EQ(shell("HOME=/nowhere sh patch_farm/task.sh 0"), 0) << read("shell.txt");
}

// A merge reads no scene, so it does not meet the configuration that the scene names.
TEST_F(FarmInputs, TheConfigurationOfTheSceneIsThatOfTheMerge) {
  write(
      "scene.json",
      R"({"models": [{"file": "patch.gltf"}], "ocio": "show.ocio", "settings": {"samples": 4, "resolution": [12, 8]}})");
  ASSERT_EQ(with("", "render scene.json -o alone.png"), 0) << read("shell.txt");
  ASSERT_EQ(with("", "farm scene.json -o farm.png --tasks 2"), 0) << read("shell.txt");
  for (const char* job : {"task.sh 0", "task.sh 1", "merge.sh"})
    EXPECT_EQ(shell(std::string("sh scene_farm/") + job), 0) << read("shell.txt");
  EXPECT_EQ(pixels("farm.png"), pixels("alone.png"));
}

// promise: farm.files.inputs, farm.inputs
TEST_F(FarmInputs, AMachineThatDiffersRefusesBeforeItRenders) {
  write_farm("OCIO=show.ocio SHOT=dark");
  const std::string task = "sh patch_farm/task.sh 0";
  const std::string lut = read("luts/dark/grade.cc"), config = read("show.ocio"), buffer = read("patch.bin");
  write("luts/dark/grade.cc", read("luts/bright/grade.cc"));
  expect_refused(task, "grade.cc: this LUT of the colour configuration is not that of the farm", "copy the farm's");
  std::filesystem::remove(folder_ / "luts/dark/grade.cc");
  expect_refused(task, "grade.cc: this LUT of the colour configuration is not found", "copy the farm's");
  write("luts/dark/grade.cc", lut);
  write("show.ocio", config + "# another\n");
  expect_refused(task, "show.ocio: the colour configuration is not that of the farm", "copy that file here");
  write("show.ocio", config);
  write("patch.bin", buffer + "x");
  expect_refused(task, "patch.bin: this file is not that of the farm", "copy the farm's file here");
  write("patch.bin", buffer);
  const std::string inputs = read("patch_farm/inputs.txt");
  const size_t embree = inputs.find("version Embree ");
  ASSERT_NE(embree, std::string::npos) << inputs;
  write("patch_farm/inputs.txt", inputs.substr(0, embree + 15) + "2.17.7" + inputs.substr(inputs.find('\n', embree)));
  expect_refused(task, "Embree: this machine has version ", "written with 2.17.7: install that version here");
  write("patch_farm/inputs.txt", "x\n");
  expect_refused(task, "inputs.txt: this is no list of inputs", "'alabaster farm' writes");
  write("patch_farm/inputs.txt", inputs);
  EXPECT_EQ(shell(task), 0) << read("shell.txt");
  EXPECT_EQ(shell("sh patch_farm/task.sh 1"), 0) << read("shell.txt");
  EXPECT_EQ(shell("sh patch_farm/task.sh 2") >> 8, 2) << "of tasks 0 and 1";
  EXPECT_EQ(shell("sh patch_farm/task.sh") >> 8, 2);
  write("luts/dark/grade.cc", read("luts/bright/grade.cc"));
  EXPECT_EQ(shell("sh patch_farm/merge.sh") >> 8, 3);
  EXPECT_NE(read("shell.txt").find("grade.cc: this LUT"), std::string::npos) << read("shell.txt");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "farm.png"));
}

// The merge denoises. Machines of tasks may have another denoiser, or none.
// promise: farm.inputs
TEST_F(FarmInputs, AMergeWithAnotherDenoiserIsRefused) {
  const testing::FakeOidn oidn;
  ASSERT_EQ(with("", std::string("farm patch.gltf -o farm.exr --denoise --tasks 2 ") + kFrame), 0) << read("shell.txt");
  const std::string inputs = read("patch_farm/inputs.txt"), line = "version Open%20Image%20Denoise ";
  const size_t found = inputs.find(line);
  ASSERT_NE(found, std::string::npos) << inputs;
  write("patch_farm/inputs.txt",
        inputs.substr(0, found + line.size()) + "2.0.9" + inputs.substr(inputs.find('\n', found)));
  for (const char* task : {"sh patch_farm/task.sh 0", "sh patch_farm/task.sh 1"})
    EXPECT_EQ(shell(task), 0) << read("shell.txt");
  EXPECT_EQ(shell("sh patch_farm/merge.sh") >> 8, 3);
  EXPECT_NE(read("shell.txt").find("Open Image Denoise: this machine has version "), std::string::npos)
      << read("shell.txt");
  EXPECT_NE(read("shell.txt").find("written with 2.0.9: install that version here"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "farm.exr"));
  write("patch_farm/inputs.txt", inputs);
  EXPECT_EQ(shell("sh patch_farm/merge.sh"), 0) << read("shell.txt");
  ASSERT_EQ(with("", std::string("farm patch.gltf -o plain.exr --folder plain --tasks 2 ") + kFrame), 0);
  EXPECT_EQ(read("plain/inputs.txt").find(line), std::string::npos) << "a frame that is not denoised";
}

// A scene whose name holds what shells, Slurm and options give a meaning, and an output that looks like an option.
// promise: farm.names.data, security.no_command
TEST_F(Farm, ANameIsDataThroughTheWholeFarm) {
  const std::string scene = "-$(touch PWNED)`touch PWNED`'\"%j {{Task.Param.Part}} #SBATCH --wrap;\xff.gltf";
  std::filesystem::copy_file(folder_ / "patch.gltf", folder_ / scene);
  ASSERT_EQ(run({"render", "--size", "8x8", "--spp", "4", "-o", "alone.exr", "--", scene}).code, 0);
  const Outcome wrote =
      run({"farm", "--output=-o.exr", "--size", "8x8", "--spp", "4", "--tasks", "2", "--engine", "slurm", "--", scene});
  ASSERT_EQ(wrote.code, 0) << wrote.err;
  write("sbatch",
        "#!/bin/sh\nfor word; do last=$word; done\nfor SLURM_ARRAY_TASK_ID in 0 1; do\n"
        "  export SLURM_ARRAY_TASK_ID\n  sh \"$last\" >&2 || exit 1\ndone\necho 7\n");
  std::filesystem::permissions(folder_ / "sbatch", std::filesystem::perms::owner_all);
  const size_t command = wrote.err.find("run them: ");
  ASSERT_NE(command, std::string::npos) << wrote.err;
  const std::string submit = wrote.err.substr(command + 10, wrote.err.find('\n', command) - command - 10);
  EXPECT_EQ(shell("PATH=.:$PATH " + submit), 0) << submit << "\n" << read("shell.txt");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "PWNED"));
  EXPECT_EQ(pixels("./-o.exr"), pixels("alone.exr"));
}

// promise: farm.names.refused
TEST_F(Farm, NamesThatEndALineAreRefused) {
  const std::string scene = "a\ntouch PWNED\n#.gltf";
  std::filesystem::copy_file(folder_ / "patch.gltf", folder_ / scene);
  for (const char* engine : {"slurm", "openjd", "script"}) {
    const Outcome outcome = run({"farm", scene, "-o", "a.exr", "--spp", "4", "--tasks", "2", "--engine", engine});
    EXPECT_EQ(outcome.code, 2) << engine;
    EXPECT_NE(outcome.err.find("'a\\x0atouch PWNED\\x0a#.gltf', has a control character"), std::string::npos)
        << outcome.err;
  }
  EXPECT_EQ(run({"farm", "patch.gltf", "-o", "a\n.exr", "--spp", "4", "--tasks", "2"}).code, 2);
  EXPECT_EQ(run({"farm", "patch.gltf", "-o", "a.exr", "--folder", "x\ry", "--spp", "4", "--tasks", "2"}).code, 2);
  for (const auto& entry : std::filesystem::directory_iterator(folder_))
    EXPECT_FALSE(entry.is_directory()) << entry.path();
}

TEST_F(Farm, AFrameThatCannotBeWrittenIsRefusedBeforeItsTasks) {
  const auto farm = [&](const char* file, std::initializer_list<const char*> more) {
    std::vector<std::string> words{"farm", "patch.gltf", "-o", file, "--spp", "4", "--tasks", "2"};
    words.insert(words.end(), more.begin(), more.end());
    return run(words);
  };
  const Outcome large = farm("a.jpg", {"--size", "65501x2"}), shown = farm("a.png", {"--display", "TV"});
  EXPECT_EQ(large.code, 2);
  EXPECT_NE(large.err.find("65500 x 65500"), std::string::npos) << large.err;
  EXPECT_EQ(shown.code, 2);
  EXPECT_NE(shown.err.find("there is no display 'TV'"), std::string::npos) << shown.err;
  EXPECT_EQ(farm("/on_other_machines/a.png", {}).code, 0);
}

TEST_F(Farm, ItsHelpListsNoOptionThatItRefuses) {
  const std::string farm = run({"farm", "--help"}).out, render = run({"render", "--help"}).out;
  for (const std::string option : {"--pixel", "--stats", "--skip-existing"}) {
    EXPECT_EQ(farm.find("\n  " + option + " "), std::string::npos) << option;
    EXPECT_NE(render.find("\n  " + option + " "), std::string::npos) << option;
  }
}

// An option that is not listed counts where it is given.
// promise: pipeline.order.job
TEST_F(Farm, ATargetOfTheSceneMayBeTakenBack) {
  write("scene.json", R"({"models": [{"file": "patch.gltf"}], "settings": {"samples": 2, "resolution": [8, 6],
    "targetError": 0.1}})");
  EXPECT_EQ(run({"farm", "scene.json", "-o", "a.exr", "--tasks", "1"}).code, 2);
  ASSERT_EQ(run({"farm", "scene.json", "-o", "a.exr", "--tasks", "1", "--target-error", "0", "--spp", "2"}).code, 0);
  EXPECT_EQ(shell("sh scene_farm/task.sh 0"), 0) << read("shell.txt");
}

TEST_F(Farm, WrongArgumentsAreRefused) {
  const auto refused = [&](const std::vector<std::string>& more, const char* said) {
    std::vector<std::string> all{"farm", "patch.gltf", "--spp", "4"};
    all.insert(all.end(), more.begin(), more.end());
    const Outcome outcome = run(all);
    EXPECT_EQ(outcome.code, 2) << said;
    EXPECT_NE(outcome.err.find(said), std::string::npos) << outcome.err;
    EXPECT_EQ(outcome.err.find("basic_string"), std::string::npos) << outcome.err;
  };
  refused({"-o", "a.exr", "--tasks", "0"}, "--tasks");
  refused({"-o", "a.exr", "--tasks", "5"}, "cannot be shared");
  refused({"--tasks", "2"}, "add -o");
  refused({"-o", "a.exr", "--tasks", "2", "--engine", "cloud"}, "choose from script, slurm, openjd");
  refused({"-o", "a.exr"}, "--tasks is required");
  refused({"-o", "a.exr", "--tasks", "2", "--frames", "1:4"}, "####");
  refused({"-o", "a.####.exr", "--tasks", "5", "--frames", "1:4"}, "4 frames cannot be shared by 5 tasks");
  refused({"-o", "a.####.exr", "--frames", "1:4", "--time", "1"}, "--frames");
  refused({"-o", "a.####.exr", "--frames", "1:4"}, "it would jump");
  refused({"-o", "a.exr", "--tasks", "2", "--target-error", "0.1"}, "error: --tasks: The setting targetError decides");
  refused({"-o", "a.exr", "--tasks", "2", "--time", "noon"}, "--time");
  refused({"-o", "a.exr", "--tasks", "2", "--crop", "1,2"}, "--crop");
  refused({"-o", "a.exr", "--tasks", "2", "--engine", "openjd", "--folder", "{{a}}"}, "begins a variable");
  refused({"-o", "a.exr", "--tasks", "2", "--engine", "openjd", "--folder", "\xff"}, "is not UTF-8");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "{{a}}"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "patch_farm"));
}

}  // namespace
}  // namespace alabaster::cli
