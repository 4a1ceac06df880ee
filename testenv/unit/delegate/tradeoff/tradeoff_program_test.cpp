// The command from outside: a whole study on a picture of a few pixels.
#include <nlohmann/json.hpp>

#include "testenv/unit/delegate/cli/run_program.h"
#include "testenv/unit/delegate/description/scene_fixture.h"

namespace alabaster::cli {
namespace {

class TradeoffProgram : public hd::description::SceneFiles {
 protected:
  struct Outcome {
    int code;
    std::string err;
  };
  Outcome run(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "tradeoff");
    Program program(folder_, arguments);
    const int code = program.wait();
    return {code, program.err()};
  }
  std::string text_of(const std::string& name) const {
    std::ifstream file(folder_ / name);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  /// Six seconds at 12x8. An idle machine has rows for a report after one second, a busy one by the end.
  std::vector<std::string> quick(const std::vector<std::string>& more) const {
    std::vector<std::string> all{"wax.json", "-o", "out", "--budget", "0.1", "--size", "12x8", "--only", "lambert"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  /// Too little time for anything but the renders that every study takes.
  std::vector<std::string> hasty(const std::vector<std::string>& more) const {
    std::vector<std::string> all = quick(more);
    all[4] = "0.00001";
    return all;
  }
  void write_sky(const std::string& pixel) const {
    write("sky.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n" + pixel + "abc\x80");
    write("wax.json", R"({"gltf": [{"file": "lit.gltf"}],
                          "lights": [{"name": "sky", "type": "domeLight", "texture:file": "sky.hdr"}],
                          "materials": [{"match": "skin", "set": {"scatterDistance": [0.2, 0.1, 0.05]}}]})");
  }
  void SetUp() override {
    SceneFiles::SetUp();
    write("wax.json", R"({"gltf": [{"file": "lit.gltf"}], "lights": [{"name": "sky", "type": "domeLight"}],
                          "materials": [{"match": "skin", "set": {"scatterDistance": [0.2, 0.1, 0.05]}}]})");
  }
};

#define EXPECT_HAS(text, part) EXPECT_NE((text).find(part), std::string::npos) << "said: " << (text)

TEST_F(TradeoffProgram, MeasuresWritesAndGoesOn) {
  const Outcome first = run(quick({}));
  ASSERT_EQ(first.code, 0) << first.err;
  EXPECT_HAS(first.err, "plan: ");
  EXPECT_HAS(first.err, " left");
  for (const char* name :
       {"tradeoff.csv", "tradeoff.json", "tradeoff.md", "tradeoff.svg", "tradeoff.png", "pictures.png"})
    EXPECT_GT(text_of(std::string("out/") + name).size(), 100u) << name;
  const auto json = nlohmann::json::parse(text_of("out/tradeoff.json"));
  EXPECT_EQ(json["configurations"].size(), 2u);
  EXPECT_EQ(json["resolution"], nlohmann::json({12, 8}));
  EXPECT_TRUE(json["complete"]);
  bool front = false;
  for (const auto& row : json["rows"]) {
    EXPECT_GT(row["cpuSeconds"].get<double>(), 0);
    EXPECT_GE(row["replicas"].get<int>(), 2);
    front = front || row["pareto"].get<bool>();
  }
  EXPECT_TRUE(front);
  const Outcome second = run(quick({}));
  EXPECT_EQ(second.code, 0);
  EXPECT_HAS(second.err, "resuming with");
}

TEST_F(TradeoffProgram, StudyOfAnotherSceneInTheFolderIsRefused) {
  write_sky("ABC\x80");
  run(hasty({}));
  EXPECT_HAS(run(hasty({})).err, "resuming with");
  const auto refuses = [&](const std::vector<std::string>& arguments, const std::string& because) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.code, 2);
    EXPECT_HAS(outcome.err, because);
    EXPECT_HAS(outcome.err, "--restart");
  };
  refuses({"wax.json", "-o", "out", "--budget", "0.00001", "--size", "13x8"}, "12x8");
  refuses(hasty({"--set", "materials/skin.roughness=0.1"}), "earlier version of");
  write_sky("ABD\x80");
  refuses(hasty({}), "earlier version of");
  write_sky("ABC\x80");
  EXPECT_HAS(run(hasty({})).err, "resuming with");
  auto state = nlohmann::json::parse(text_of("out/state/state.json"));
  state["versions"] = "0.0.1";
  write("out/state/state.json", state.dump());
  refuses(hasty({}), "another version");
  state.erase("versions");  // as written by a program that did not record them
  write("out/state/state.json", state.dump());
  refuses(hasty({}), "another version");
  const Outcome anew = run(hasty({"--restart"}));
  EXPECT_EQ(anew.err.find("holds a study"), std::string::npos) << anew.err;
  EXPECT_HAS(run(hasty({})).err, "resuming with");
}

TEST_F(TradeoffProgram, TooShortATimeIsSaidAndNothingIsLost) {
  const Outcome outcome = run(hasty({}));
  EXPECT_EQ(outcome.code, 2);
  EXPECT_HAS(outcome.err, "--budget: ");
  EXPECT_HAS(outcome.err, "minutes or more");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out" / "tradeoff.csv"));
  EXPECT_HAS(run(hasty({})).err, "resuming with 3 renders");  // one of the base, two of the reference
}

TEST_F(TradeoffProgram, WrongArgumentsEndAsWithOtherCommands) {
  EXPECT_EQ(run({}).code, 2);
  const Outcome budget = run({"wax.json", "--budget", "-3"});
  EXPECT_EQ(budget.code, 2);
  EXPECT_HAS(budget.err, "minutes");
  EXPECT_EQ(run({"wax.json", "--budget", "nan"}).code, 2);
  EXPECT_EQ(run({"wax.json", "--size", "huge"}).code, 2);
  EXPECT_EQ(run({"wax.json", "--only", "("}).code, 2);
  const Outcome typo = run({"wax.json", "--only", "lambret"});
  EXPECT_EQ(typo.code, 2);
  EXPECT_HAS(typo.err, "walk, quality=preview");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "wax_tradeoff"));
  EXPECT_EQ(run({"wax.json", "--set", "materials/skin.rougness=1", "-o", "out"}).code, 2);
  EXPECT_EQ(run({"missing.glb"}).code, 3);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "missing_tradeoff"));
  const Outcome unwritable = run({"wax.json", "-o", "/proc/nowhere"});
  EXPECT_EQ(unwritable.code, 5);
  EXPECT_HAS(unwritable.err, "-o");
}

TEST_F(TradeoffProgram, InterruptedItWritesWhatThereIs) {
  Program program(folder_,
                  {"tradeoff", "wax.json", "-o", "out", "--budget", "5", "--size", "12x8", "--only", "lambert"});
  ASSERT_TRUE(program.wait_for("[8/", 30)) << program.err();
  program.interrupt();
  EXPECT_EQ(program.wait(), 130) << program.err();
  EXPECT_TRUE(std::filesystem::exists(folder_ / "out" / "state" / "state.json"));
  EXPECT_HAS(program.err(), "run the same command again to resume");
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_ / "out"))
    EXPECT_EQ(entry.path().string().find(".tmp"), std::string::npos) << entry.path();
}

}  // namespace
}  // namespace alabaster::cli
