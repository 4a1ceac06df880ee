// --quality from outside: the settings that a render with a preset reports.
#include <nlohmann/json.hpp>

#include "delegate/description/quality_presets.h"
#include "testenv/unit/delegate/cli/run_program.h"
#include "testenv/unit/delegate/description/scene_fixture.h"

namespace alabaster::cli {
namespace {

using nlohmann::json;

class QualityTest : public hd::description::SceneFiles {
 protected:
  /// The settings in the statistics of a render of one pixel of `scene`; null if it failed.
  json settings_of(const std::string& scene, const std::vector<std::string>& more) const {
    std::vector<std::string> words{"render",      scene, "--size", "32x24",   "--crop",
                                   "16,12,17,13", "-o",  "a.exr",  "--stats", "s.json"};
    words.insert(words.end(), more.begin(), more.end());
    Program program(folder_, words);
    EXPECT_EQ(program.wait(), 0) << program.err();
    std::ifstream file(folder_ / "s.json");
    return json::parse(file, nullptr, false).value("settings", json());
  }
};

TEST_F(QualityTest, APresetRendersWithExactlyItsSettings) {
  write("scene.json",
        R"({"gltf": [{"file": "lit.gltf"}], "settings": {"subsurface": "diffusion", "maxDepth": 2, "samples": 3,
                          "targetError": 0.9, "seed": 11}})");
  const json plain = settings_of("scene.json", {});
  const json presets = json::parse(hd::description::SchemaText("quality_presets"));
  for (const json& preset : presets.at("presets")) {
    json expected = plain;
    expected.update(preset["settings"]);
    EXPECT_EQ(settings_of("scene.json", {"--quality", preset["name"]}), expected) << preset["name"];
  }
}

TEST_F(QualityTest, EveryOtherFlagWins) {
  json expected = settings_of("lit.gltf", {"--quality", "draft"});
  expected.update({{"samples", 5}, {"maxDepth", 3}, {"subsurface", "lambert"}, {"inversion", "chiang2016"}});
  EXPECT_EQ(settings_of("lit.gltf", {"--spp", "5", "--max-depth", "3", "--set", "inversion=chiang2016", "--quality",
                                     "draft", "--subsurface", "lambert"}),
            expected);
}

// --target-error and --time-limit set their own bound on samples, as they do without a preset. The bound is never below
// the preset's, so that a smaller error cannot end with fewer samples.
// promise: trade_off.ends.first
TEST_F(QualityTest, AnErrorOrATimeRaisesTheBoundOfSamplesAndNeverLowersIt) {
  const int of_reference = settings_of("lit.gltf", {"--quality", "reference", "--time-limit", "0.01"})["samples"];
  EXPECT_GT(of_reference, 65536) << "or there is nothing to lower";
  const json presets = json::parse(hd::description::SchemaText("quality_presets"));
  for (const json& preset : presets.at("presets")) {
    const int bound = std::max(65536, preset["settings"]["samples"].get<int>());
    const json exact = settings_of("lit.gltf", {"--quality", preset["name"], "--target-error", "0.5"});
    EXPECT_EQ(exact["targetError"], 0.5);
    EXPECT_EQ(exact["samples"], bound) << preset["name"];
    const json timed = settings_of("lit.gltf", {"--quality", preset["name"], "--time-limit", "0.01"});
    EXPECT_EQ(timed["targetError"], settings_of("lit.gltf", {"--quality", preset["name"]})["targetError"]);
    EXPECT_EQ(timed["samples"], bound) << preset["name"];
    const json bounded = settings_of("lit.gltf", {"--quality", preset["name"], "--target-error", "0.5", "--spp", "32"});
    EXPECT_EQ(bounded["samples"], 32) << preset["name"];
  }
}

TEST_F(QualityTest, AnUnknownPresetIsRefused) {
  Program program(folder_, {"render", "lit.gltf", "-o", "a.exr", "--quality", "final"});
  EXPECT_EQ(program.wait(), 2);
  for (const auto& preset : hd::description::QualityPresets())
    EXPECT_NE(program.err().find(preset.name), std::string::npos) << program.err();
}

TEST_F(QualityTest, ThePresetsCanBePrinted) {
  Program program(folder_, {"schema", "quality_presets"});
  EXPECT_EQ(program.wait(), 0);
  EXPECT_EQ(program.out(), hd::description::SchemaText("quality_presets"));
}

}  // namespace
}  // namespace alabaster::cli
