// Renders that end before their target error, from outside: each says so, and what the target would take.
#include <OpenImageIO/imageio.h>

#include <nlohmann/json.hpp>

#include "testenv/unit/delegate/cli/run_program.h"
#include "testenv/unit/delegate/description/scene_fixture.h"

namespace alabaster::cli {
namespace {

#define EXPECT_HAS(text, part) EXPECT_NE((text).find(part), std::string::npos) << "said: " << (text)

using TargetErrorTest = hd::description::SceneFiles;

TEST_F(TargetErrorTest, ALimitOfSamplesThatMissesItIsToldEverywhere) {
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

TEST_F(TargetErrorTest, ATimeLimitThatMissesItIsTold) {
  Program program(folder_, {"render", "patch.gltf", "--size", "96x64", "--target-error", "0.0001", "--time-limit",
                            "0.5", "-o", "a.exr", "--stats", "s.json", "--quiet"});
  ASSERT_EQ(program.wait(), 0) << program.err();
  EXPECT_HAS(program.err(), "The time limit ended the render after ");
  EXPECT_EQ(nlohmann::json::parse(std::ifstream(folder_ / "s.json"))["target"]["endedBy"], "timeLimit");
}

TEST_F(TargetErrorTest, OneThatIsReachedNeedsNoWord) {
  Program program(folder_, {"render", "patch.gltf", "--size", "48x32", "--target-error", "0.1", "-o", "a.exr",
                            "--stats", "s.json", "--quiet"});
  ASSERT_EQ(program.wait(), 0) << program.err();
  EXPECT_EQ(program.err(), "");
  const auto target = nlohmann::json::parse(std::ifstream(folder_ / "s.json"))["target"];
  EXPECT_FALSE(target["missed"].get<bool>());
  EXPECT_EQ(target["endedBy"], "targetError");
  EXPECT_FALSE(target.contains("samples"));
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
