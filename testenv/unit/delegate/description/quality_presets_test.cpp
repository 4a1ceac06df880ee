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

// A changed preset must be measured again, and what it promises must hold.
TEST_F(QualityPresetsTest, ReachWhatTheyPromise) {
  json before = json::object();  // the measurements of the coarser preset
  for (const json& preset : presets_file()["presets"]) {
    if (!preset.contains("promisedError")) continue;
    const double promised = preset["promisedError"];
    EXPECT_LT(preset["settings"]["targetError"], promised) << "room for the bias";
    const json& measured = preset.at("measured");
    EXPECT_EQ(measured["settings"], preset["settings"]) << preset["name"] << ": " << measured["command"];
    EXPECT_FALSE(measured["command"].get<std::string>().empty());
    EXPECT_GE(measured["scenes"].size(), 12u);
    int ended_by_samples = 0, missed = 0;
    for (const auto& [scene_name, numbers] : measured["scenes"].items()) {
      const bool at_the_limit = numbers["endedBy"] == "samples";
      ended_by_samples += at_the_limit ? 1 : 0;
      missed += !at_the_limit && numbers["error"] > 1.2 * promised ? 1 : 0;
      EXPECT_LE(numbers["samples"], preset["settings"]["samples"]) << scene_name;
      if (const json& coarser = before.value(scene_name, json()); !coarser.is_null()) {
        EXPECT_LT(numbers["error"], coarser["error"]) << preset["name"] << " " << scene_name;
        EXPECT_GT(numbers["cpuSeconds"], coarser["cpuSeconds"]) << preset["name"] << " " << scene_name;
      }
      EXPECT_GT(numbers["cpuSeconds"], 0) << scene_name;
    }
    EXPECT_LE(ended_by_samples, 2) << preset["name"];
    EXPECT_LE(missed, 1) << preset["name"];
    before = measured["scenes"];
  }
}

}  // namespace
}  // namespace alabaster::hd::description
