// Renders that end before their target error, from outside: each says so, and what the target would take.
#include <OpenImageIO/imageio.h>

#include <nlohmann/json.hpp>

#include "testenv/support/build_paths.h"
#include "testenv/unit/delegate/cli/run_program.h"
#include "testenv/unit/delegate/description/scene_fixture.h"

namespace alabaster::cli {
namespace {

#define EXPECT_HAS(text, part) EXPECT_NE((text).find(part), std::string::npos) << "said: " << (text)

class TargetErrorTest : public hd::description::SceneFiles {
 protected:
  std::string said_;
};

// promise: pipeline.stats.target
TEST_F(TargetErrorTest, MissedTargetAtTheSampleLimitIsReportedEverywhere) {
  Program program(folder_, {"render", "patch.gltf", "--size", "48x32", "--target-error", "0.001", "--spp", "16", "-o",
                            "a.exr", "--stats", "s.json", "--quiet"});
  ASSERT_EQ(program.wait(), 0) << program.err();
  EXPECT_HAS(program.err(),
             "The limit of samples per pixel ended the render after 16 samples per pixel. Its error is ");
  EXPECT_HAS(program.err(), "its target was 0.001, which would take about ");
  const auto stats = nlohmann::json::parse(std::ifstream(folder_ / "s.json"));
  const auto target = stats["target"];
  EXPECT_TRUE(target["missed"].get<bool>());
  EXPECT_EQ(target["endedBy"], "samples");
  const double error = stats["error"]["relativeRmse"], more = std::pow(error / 0.001, 2);
  EXPECT_GT(more, 100);
  EXPECT_NEAR(target["samples"].get<double>() / (16 * more), 1, 0.01);
  EXPECT_GT(target["seconds"].get<double>(), 0);
  const auto exr = OIIO::ImageInput::open(folder_ / "a.exr");
  ASSERT_TRUE(exr) << OIIO::geterror();
  EXPECT_EQ(exr->spec().get_string_attribute("alabaster/endedBy"), "samples");
  EXPECT_EQ(exr->spec().get_int_attribute("alabaster/target/missed", 0), 1);
  EXPECT_FLOAT_EQ(exr->spec().get_float_attribute("alabaster/target/samples"), target["samples"].get<float>());
}

TEST_F(TargetErrorTest, MissedTargetAtTheTimeLimitIsReported) {
  Program program(folder_, {"render", "patch.gltf", "--size", "96x64", "--target-error", "0.0001", "--time-limit",
                            "0.5", "-o", "a.exr", "--stats", "s.json", "--quiet"});
  ASSERT_EQ(program.wait(), 0) << program.err();
  EXPECT_HAS(program.err(), "The time limit ended the render after ");
  EXPECT_EQ(nlohmann::json::parse(std::ifstream(folder_ / "s.json"))["target"]["endedBy"], "timeLimit");
}

// A render without a report has an error of at most a fifth above its target, as surely as its interval holds.
TEST_F(TargetErrorTest, AnIntervalThatEndsAFifthAboveTheTargetIsReported) {
  const auto stats_with = [&](const std::string& target) {
    Program program(folder_, {"render", "patch.gltf", "--size", "12x8", "--spp", "16", "--target-error", target, "-o",
                              "a.exr", "--stats", "s.json", "--quiet"});
    EXPECT_EQ(program.wait(), 0) << program.err();
    said_ = program.err();
    return nlohmann::json::parse(std::ifstream(folder_ / "s.json"));
  };
  const auto first = stats_with("0.001");
  const double reported = first["error"]["relativeRmse"], high = first["error"]["high95"];
  ASSERT_LT(reported, high / 1.24);
  const auto wide = stats_with(std::to_string(high / 1.22));
  EXPECT_EQ(wide["error"]["high95"], high);
  EXPECT_TRUE(wide["target"]["missed"].get<bool>());
  EXPECT_NEAR(wide["target"]["samples"].get<double>() / 16, std::pow(1.22 / 1.2, 2), 0.07);
  EXPECT_HAS(said_, " and may be up to ");
  EXPECT_FALSE(stats_with(std::to_string(high / 1.18))["target"]["missed"].get<bool>());
  EXPECT_EQ(said_, "");
}

TEST_F(TargetErrorTest, ReachedTargetIsNotReported) {
  Program program(folder_, {"render", "patch.gltf", "--size", "48x32", "--target-error", "0.1", "-o", "a.exr",
                            "--stats", "s.json", "--quiet"});
  ASSERT_EQ(program.wait(), 0) << program.err();
  EXPECT_EQ(program.err(), "");
  const auto target = nlohmann::json::parse(std::ifstream(folder_ / "s.json"))["target"];
  EXPECT_FALSE(target["missed"].get<bool>());
  EXPECT_EQ(target["endedBy"], "targetError");
  EXPECT_FALSE(target.contains("samples"));
}

// A few bright samples make most of this frame's error: it may be six times what they tell.
TEST_F(TargetErrorTest, TargetReachedWithFewSamplesIsCalledUncertain) {
  const std::string scene = testing::source_file("testenv/scenes/dome_high_contrast/dome_high_contrast.json");
  const auto render = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words{"render", scene,   "--size",  "36x24",  "--spp",  "16",
                                   "-o",     "a.exr", "--stats", "s.json", "--quiet"};
    words.insert(words.end(), more.begin(), more.end());
    Program program(folder_, words);
    EXPECT_EQ(program.wait(), 0) << program.err();
    said_ = program.err();
    return nlohmann::json::parse(std::ifstream(folder_ / "s.json"));
  };
  const auto error = render({})["error"];
  const double value = error["relativeRmse"], high = error["high95"];
  ASSERT_TRUE(error["isKnown"].get<bool>());
  ASSERT_GT(high, 2 * value);
  const double target = 1.05 * value;
  const auto told = render({"--target-error", std::to_string(target)});
  ASSERT_LT(told["error"]["relativeRmse"].get<double>(), target);
  EXPECT_TRUE(told["target"]["missed"].get<bool>());
  EXPECT_HAS(said_, " and may be up to ");
  const double doubt = std::pow(std::hypot(value, high - value) / target, 2);
  EXPECT_NEAR(told["target"]["samples"].get<double>() / (16 * doubt), 1, 0.02);
}

// Nothing differs in it, which may be the truth, or light that no sample has found.
TEST_F(TargetErrorTest, ABlackFrameIsNoZeroError) {
  Program program(folder_, {"render", "patch.gltf", "--size", "16x16", "--target-error", "0.1", "-o", "a.exr",
                            "--studio", "off", "--dome", "0", "--stats", "s.json"});
  ASSERT_EQ(program.wait(), 0) << program.err();
  EXPECT_HAS(program.err(), "noise: not known (no sample differs from another)");
  EXPECT_HAS(program.err(), "Whether it reached its target error of 0.1 is not known");
  EXPECT_FALSE(nlohmann::json::parse(std::ifstream(folder_ / "s.json"))["error"]["isKnown"].get<bool>());
}

}  // namespace
}  // namespace alabaster::cli
