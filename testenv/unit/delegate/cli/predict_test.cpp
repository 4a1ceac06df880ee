// alabaster info --predict, compared with renders to the same error.
#include <sys/resource.h>

#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "testenv/support/build_paths.h"
#include "testenv/unit/delegate/cli/run_program.h"
#include "testenv/unit/delegate/description/scene_fixture.h"

namespace alabaster::cli {
namespace {

struct Said {
  double value = 0, low = 0, high = 0;
};

class PredictTest : public hd::description::SceneFiles {
 protected:
  int run(const std::vector<std::string>& arguments) {
    Program program(folder_, arguments);
    const int code = program.wait();
    out_ = program.out();
    err_ = program.err();
    return code;
  }
  /// "  name   VALUE unit (LOW to HIGH)"
  Said said(const std::string& name) const {
    Said s;
    const size_t line = out_.find("  " + name + " ");
    if (line == std::string::npos) return s;
    s.value = std::atof(out_.c_str() + line + 2 + name.size());
    const size_t open = out_.find('(', line);
    EXPECT_EQ(std::sscanf(out_.c_str() + open, "(%lf to %lf)", &s.low, &s.high), 2) << out_;
    EXPECT_LE(s.low, s.value) << name;
    EXPECT_GE(s.high, s.value) << name;
    return s;
  }
  std::string out_, err_;
};

TEST_F(PredictTest, PredictsSamplesAndMemory) {
  const std::string scene = testing::source_file("testenv/scenes/sample/sample.json");
  ASSERT_EQ(run({"info", scene, "--predict", "0.15", "--size", "120x80"}), 0) << err_;
  const Said samples = said("samples per pixel"), memory = said("peak memory");
  EXPECT_GT(said("wall time").value, 0) << out_;
  EXPECT_GT(said("CPU time").value, 0);
  ASSERT_EQ(run({"render", scene, "--size", "120x80", "--target-error", "0.15", "-o", "a.exr", "--stats", "s.json"}), 0)
      << err_;
  const auto stats = nlohmann::json::parse(std::ifstream(folder_ / "s.json"));
  const double taken = stats["samples"]["total"].get<double>() / (120 * 80);
  // A busy machine leaves the probe few samples; the range says so.
  EXPECT_GT(taken, 0.8 * samples.low) << samples.value;
  EXPECT_LT(taken, 1.25 * samples.high) << samples.value;
  const double peak = stats["peakMemory"].get<double>() / 1e6;
  EXPECT_GT(memory.value, 0.7 * peak) << peak;
  EXPECT_LT(memory.value, 1.3 * peak) << peak;
}

// promise: pipeline.predict
TEST_F(PredictTest, TakesTheOptionsOfARender) {
  const std::string scene = testing::source_file("testenv/scenes/sample/sample.json");
  const auto listed = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"info", scene, "--json", "--predict", "0.02", "--size", "24x16"});
    EXPECT_EQ(run(more), 0) << err_;
    return nlohmann::json::parse(out_);
  };
  const auto usual = listed({}), lit = listed({"--dome", "1,1,1", "--set", "maxDepth=2"});
  EXPECT_NE(usual["lights"], lit["lights"]);
  EXPECT_GT(usual["prediction"]["samplesPerPixel"]["value"], lit["prediction"]["samplesPerPixel"]["value"]);
  const auto cut = listed({"--spp", "5", "--crop", "0,0,8,8", "-o", "a.exr", "--aov", "normal"});
  EXPECT_EQ(cut["prediction"]["mostSamples"], 5);
  EXPECT_EQ(cut["renders"][0]["crop"], std::vector<int>({0, 0, 8, 8}));
  EXPECT_EQ(cut["renders"][0]["files"], std::vector<std::string>{"a.exr"});
  EXPECT_FALSE(std::filesystem::exists(folder_ / "a.exr"));
}

// Most of a tiny render's time is the start of the program, its images and the libraries that write its file.
TEST_F(PredictTest, CountsTheStartOfTheProgram) {
  const auto cpu_of_children = [] {
    rusage usage{};
    getrusage(RUSAGE_CHILDREN, &usage);
    return double(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
           1e-6 * double(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
  };
  for (const std::string& scene :
       {std::string("lit.gltf"), testing::source_file("testenv/scenes/sample/sample.json")}) {
    ASSERT_EQ(run({"info", scene, "--predict", "0.5", "--size", "16x12", "--threads", "1"}), 0) << err_;
    const Said cpu = said("CPU time");
    const double before = cpu_of_children();
    ASSERT_EQ(run({"render", scene, "--target-error", "0.5", "--size", "16x12", "--threads", "1", "-o", "a.exr"}), 0)
        << err_;
    const double taken = cpu_of_children() - before;
    EXPECT_GT(cpu.value, 0.5 * taken) << scene;
    EXPECT_LT(cpu.value, 2 * taken) << scene;
  }
}

TEST_F(PredictTest, LeavesNothingBehind) {
  const auto files = [&] { return std::distance(std::filesystem::directory_iterator(folder_), {}); };
  ASSERT_EQ(setenv("TMPDIR", folder_.c_str(), 1), 0);
  ASSERT_EQ(run({"info", "lit.gltf", "--predict", "0.5", "--size", "16x12"}), 0)
      << err_;  // makes stdout.txt, stderr.txt
  const auto before = files();
  ASSERT_EQ(run({"info", "lit.gltf", "--predict", "0.5", "--size", "16x12"}), 0) << err_;
  unsetenv("TMPDIR");
  EXPECT_EQ(files(), before);
  EXPECT_EQ(said("samples per pixel").value, 16) << "the first look is enough: " << out_;
}

TEST_F(PredictTest, AnInterruptedProbeCleansUp) {
  const std::filesystem::path temporary = folder_ / "temporary";
  std::filesystem::create_directory(temporary);
  const auto is_empty = [&] { return std::filesystem::is_empty(temporary); };
  ASSERT_EQ(setenv("TMPDIR", temporary.c_str(), 1), 0);
  Program program(folder_, {"info", testing::source_file("testenv/scenes/sample/sample.json"), "--predict", "0.01"});
  unsetenv("TMPDIR");
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (is_empty() && std::chrono::steady_clock::now() < until)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  ASSERT_FALSE(is_empty()) << "the probe writes nothing: " << program.err();
  program.interrupt();
  std::this_thread::sleep_for(std::chrono::milliseconds(1));
  program.interrupt();
  EXPECT_EQ(program.wait(), 130) << program.err();
  EXPECT_TRUE(is_empty());
  EXPECT_NE(program.err().find("interrupted"), std::string::npos) << program.err();
  EXPECT_EQ(program.out().find("predicted for"), std::string::npos) << program.out();
}

TEST_F(PredictTest, APictureThatIsNotFiniteHasNoPrediction) {
  std::ofstream(folder_ / "bright.json") << R"({
    "gltf": [{"file": "patch.gltf"}], "camera": {"exposure": 28},
    "lights": [{"name": "sky", "type": "domeLight", "intensity": 1e30}]})";
  EXPECT_EQ(run({"info", "bright.json", "--predict", "0.1", "--size", "32x24"}), 4);
  EXPECT_NE(err_.find("The mean of the picture is not finite"), std::string::npos) << err_;
  EXPECT_EQ(out_.find("predicted for"), std::string::npos) << out_;
}

TEST_F(PredictTest, SaysWhatARenderNeedsToBeAllowed) {
  const std::vector<std::string> probe{"info", "patch.gltf", "--size", "32x24", "--predict"};
  auto ask = [&](const char* error) {
    auto all = probe;
    all.emplace_back(error);
    EXPECT_EQ(run(all), 0) << err_;
    return out_.find("add --spp") != std::string::npos;
  };
  EXPECT_TRUE(ask("0.00001"));
  EXPECT_FALSE(ask("0.2"));
  EXPECT_NE(out_.find("light that the probe has not met"), std::string::npos) << out_;
}

TEST_F(PredictTest, RefusesWhatIsNoError) {
  for (const char* bad : {"0", "-0.1", "1.5", "nan", "two", "0.02x", "inf"}) {
    EXPECT_EQ(run({"info", "lit.gltf", "--predict", bad}), 2) << bad;
    EXPECT_NE(err_.find("above 0 and at most 1"), std::string::npos) << err_;
  }
  EXPECT_EQ(run({"info", "lit.gltf", "--predict", "0.1", "--size", "wide"}), 2);
  EXPECT_NE(err_.find("1280x720"), std::string::npos) << err_;
  EXPECT_EQ(run({"info", "lit.gltf", "--predict", "0.1", "--threads", "-2"}), 2);
}

}  // namespace
}  // namespace alabaster::cli
