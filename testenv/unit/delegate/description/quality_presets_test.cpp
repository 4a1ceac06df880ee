// The presets agree with the renderer's settings and with their measurements.
#include "delegate/description/quality_presets.h"

#include <nlohmann/json.hpp>

#include "delegate/api/render_delegate.h"
#include "testenv/unit/delegate/description/scene_fixture.h"

namespace alabaster::hd::description {
namespace {

using nlohmann::json;

const json& presets_file() {
  static const json file = json::parse(SchemaText("quality_presets"));
  return file;
}

class QualityPresetsTest : public SceneFiles {
 protected:
  const Dictionary& loaded(const SceneFile& file) const {
    return scene.GetAllRenderSettings().at(file.settings).settings;
  }
};

TEST_F(QualityPresetsTest, AreNamedInTheOrderOfTheSchema) {
  const json schema = json::parse(SchemaText("render_description"));
  std::vector<std::string> names;
  for (const QualityPreset& preset : QualityPresets()) {
    names.push_back(preset.name);
    EXPECT_EQ(FindQualityPreset(preset.name), &preset);
    EXPECT_FALSE(preset.description.empty());
    EXPECT_EQ(preset.description.find('\n'), std::string::npos);
  }
  EXPECT_EQ(json(names), schema.at("properties").at("settings").at("properties").at("quality").at("enum"));
  EXPECT_EQ(FindQualityPreset("final"), nullptr);
  EXPECT_EQ(FindQualityPreset(""), nullptr);
}

TEST_F(QualityPresetsTest, AreAcceptedByTheSchema) {
  for (const json& preset : presets_file()["presets"]) {
    ASSERT_TRUE(describe(json{{"gltf", {{{"file", "lit.gltf"}}}}, {"settings", preset["settings"]}}.dump()).ok)
        << preset["name"] << " " << errors();
    EXPECT_TRUE(diagnostics.empty());
  }
}

TEST_F(QualityPresetsTest, AreAcceptedByTheRenderer) {
  std::vector<Diagnostic> reports;
  DelegateOptions options;
  options.diagnostics = [&](const Diagnostic& d) { reports.push_back(d); };
  RenderDelegate* delegate = CreateAlabasterRenderDelegate(kAbiVersion, &options);
  ASSERT_TRUE(delegate);
  for (const QualityPreset& preset : QualityPresets())
    for (const auto& [name, value] : preset.settings) {
      delegate->SetRenderSetting(name, value);
      const Value held = delegate->GetRenderSetting(name);
      EXPECT_EQ(held.text_or(""), value.text_or("")) << preset.name << " " << name;
      EXPECT_EQ(held.number_or(-1), value.number_or(-1)) << preset.name << " " << name;
    }
  DestroyAlabasterRenderDelegate(delegate);
  for (const Diagnostic& d : reports) ADD_FAILURE() << d.where << ": " << d.text;
}

TEST_F(QualityPresetsTest, GetFinerAndNeverCoarser) {
  const auto& presets = QualityPresets();
  for (size_t i = 1; i < presets.size(); ++i) {
    const auto number = [&](size_t which, const char* name) { return presets[which].settings.at(name).number_or(-1); };
    EXPECT_LT(number(i, "targetError"), number(i - 1, "targetError"));
    EXPECT_GT(number(i, "samples"), number(i - 1, "samples"));
    EXPECT_GE(number(i, "maxDepth"), number(i - 1, "maxDepth"));
  }
}

TEST_F(QualityPresetsTest, StandInASceneAndGiveWayToWhatIsBesideThem) {
  SceneFile file =
      describe(R"({"gltf": [{"file": "lit.gltf"}], "settings": {"quality": "draft", "maxDepth": 3, "seed": 5}})");
  ASSERT_TRUE(file.ok) << errors();
  Dictionary expected = FindQualityPreset("draft")->settings;
  EXPECT_NE(expected.at("maxDepth").number_or(-1), 3);
  expected["maxDepth"] = loaded(file).at("maxDepth");
  expected["seed"] = loaded(file).at("seed");
  EXPECT_EQ(loaded(file), expected);
  EXPECT_EQ(loaded(file).at("maxDepth").number_or(-1), 3);

  file =
      describe(R"({"gltf": [{"file": "lit.gltf"}], "settings": {"subsurface": "diffusion", "samples": 7, "seed": 5}})",
               with_overrides({"quality=preview", "samples=9"}));
  ASSERT_TRUE(file.ok) << errors();
  expected = FindQualityPreset("preview")->settings;
  expected["seed"] = loaded(file).at("seed");
  expected["samples"] = loaded(file).at("samples");
  EXPECT_EQ(loaded(file), expected);
  EXPECT_EQ(loaded(file).at("samples").number_or(-1), 9);
}

TEST_F(QualityPresetsTest, AWrongNameIsAnError) {
  EXPECT_FALSE(describe(R"({"gltf": [{"file": "lit.gltf"}], "settings": {"quality": "prodction"}})").ok);
  EXPECT_NE(errors().find("production"), std::string::npos) << errors();
}

// A changed preset must be measured again.
TEST_F(QualityPresetsTest, WereMeasuredAsTheyAre) {
  const json presets = presets_file()["presets"];
  const auto by_name = [&](const std::string& name) {
    return *std::find_if(presets.begin(), presets.end(), [&](const json& p) { return p["name"] == name; });
  };
  const json production = by_name("production")["measured"]["scenes"];
  for (const json& preset : presets) {
    const json& measured = preset.at("measured");
    EXPECT_EQ(measured["settings"], preset["settings"]) << preset["name"] << ": " << measured["command"];
    EXPECT_FALSE(measured["command"].get<std::string>().empty());
    ASSERT_EQ(measured["scenes"].size(), production.size()) << preset["name"];
    ASSERT_GE(measured["scenes"].size(), 1u);
    for (const auto& [scene_name, numbers] : measured["scenes"].items()) {
      const json& base = production.at(scene_name);
      EXPECT_GT(numbers["error"], 0) << scene_name;
      EXPECT_GT(numbers["cpuSeconds"], 0) << scene_name;
      // Three digits are written.
      EXPECT_NEAR(
          numbers["errorOfProduction"].get<double>() * base["error"].get<double>() / numbers["error"].get<double>(), 1,
          0.02)
          << preset["name"] << " " << scene_name;
      EXPECT_NEAR(numbers["timeOfProduction"].get<double>() * base["cpuSeconds"].get<double>() /
                      numbers["cpuSeconds"].get<double>(),
                  1, 0.02)
          << preset["name"] << " " << scene_name;
    }
  }
}

// Numbers measured with another targetError or bound on samples do not pass, wherever the settings are written.
TEST_F(QualityPresetsTest, WereMeasuredWhereTheyEnd) {
  for (const json& preset : presets_file()["presets"]) {
    const double target = preset["settings"]["targetError"];
    const int most = preset["settings"]["samples"];
    for (const auto& [scene_name, numbers] : preset["measured"]["scenes"].items()) {
      const double noise = numbers["noise"], bias = numbers["bias"];
      const int samples = numbers["samples"];
      const std::string where = preset["name"].get<std::string>() + " " + scene_name;
      EXPECT_NEAR(std::hypot(noise, bias) / numbers["error"].get<double>(), 1, 0.02) << where;
      EXPECT_LE(samples, most) << where;
      if (samples < most) {
        EXPECT_LE(noise, 1.01 * target) << where;
      }
      // One sample less does not reach it.
      if (samples >= 20) {
        EXPECT_GE(noise, 0.9 * target) << where;
      }
    }
  }
}

// Presets are points on the front of error against time: more time means less error, in every scene.
TEST_F(QualityPresetsTest, AreAFrontInEveryMeasuredScene) {
  const json presets = presets_file()["presets"];
  for (size_t i = 1; i < presets.size(); ++i)
    for (const auto& [scene_name, finer] : presets[i]["measured"]["scenes"].items()) {
      const json& coarser = presets[i - 1]["measured"]["scenes"].at(scene_name);
      EXPECT_LT(finer["error"], coarser["error"]) << presets[i]["name"] << " " << scene_name;
      EXPECT_GT(finer["cpuSeconds"], coarser["cpuSeconds"]) << presets[i]["name"] << " " << scene_name;
    }
}

/// The scenes for measurements: the rows of the table in testenv/scenes/README.md.
std::vector<std::string> bundled_scenes() {
  std::ifstream file(ALABASTER_SOURCE_DIR "/testenv/scenes/README.md");
  std::vector<std::string> names;
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("| `")) names.push_back(line.substr(3, line.find('`', 3) - 3));
  return names;
}

TEST_F(QualityPresetsTest, WereMeasuredOnEveryBundledScene) {
  const std::vector<std::string> scenes = bundled_scenes();
  ASSERT_EQ(scenes.size(), 6u) << "the table in testenv/scenes/README.md";
  const json measured = presets_file()["presets"].at(0)["measured"]["scenes"];  // all presets have the same
  std::string missing;
  for (const std::string& name : scenes)
    if (!measured.contains(name)) missing += " " + name;
  EXPECT_EQ(missing, "") << "measure the presets on them: testenv/statistical/results/README.md";
}

}  // namespace
}  // namespace alabaster::hd::description
