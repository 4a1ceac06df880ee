#include "delegate/tradeoff/configurations.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "delegate/description/quality_presets.h"

namespace alabaster::tradeoff {
namespace {

/// The renderer's own settings, because measured settings must exist.
std::vector<hd::RenderSettingDescriptor> known() {
  hd::RenderDelegate* delegate = CreateAlabasterRenderDelegate(hd::kAbiVersion, nullptr);
  auto descriptors = delegate->GetRenderSettingDescriptors();
  DestroyAlabasterRenderDelegate(delegate);
  return descriptors;
}

std::set<std::string> names(const ConfigurationList& list) {
  std::set<std::string> names;
  for (const Configuration& c : list.measured) EXPECT_TRUE(names.insert(c.name).second) << c.name << " twice";
  return names;
}

TEST(Configurations, EveryRungAndKnobOfASceneThatHasAll) {
  const ConfigurationList list = make_configurations({true, true, 2}, {}, known(), ".");
  const auto all = names(list), usual = names(make_configurations({true, true, 2}, {}, known(), ""));
  for (const char* name : {"walk", "quality=preview", "quality=draft", "lambert", "diffusion", "reference",
                           "maxDepth=2", "maxDepth=16", "adaptive=on", "glossyFilter=0.5", "textureFilter=0.5"})
    EXPECT_TRUE(all.count(name) && usual.count(name)) << name;
  for (const char* name :
       {"walkGuiding=off", "walkSphereSteps=off", "inversion=chiang2016", "refineLevel-1", "refineLevel-2"}) {
    EXPECT_TRUE(all.count(name)) << name;
    EXPECT_FALSE(usual.count(name)) << name << " is hardly a choice of users";
  }
  EXPECT_TRUE(list.skipped.empty());
  EXPECT_EQ(list.measured.front().name, "walk");
  EXPECT_EQ(list.reference.settings.at("subsurface").text_or(""), "reference");
}

TEST(Configurations, EachDiffersFromTheBaseInOneThing) {
  const ConfigurationList list = make_configurations({true, true, 3}, {{"filter", std::string("box")}}, known(), ".");
  const Configuration& base = list.measured.front();
  std::set<std::string> fingerprints;
  for (const Configuration& c : list.measured) {
    EXPECT_TRUE(fingerprints.insert(c.fingerprint()).second) << c.name;
    EXPECT_EQ(c.flags.empty(), c.name == "walk" || c.coarser != 0) << c.name;
    if (c.group == "quality") continue;
    int differences = c.coarser != 0;
    for (const auto& [key, value] : c.settings)
      differences += !base.settings.count(key) || !(base.settings.at(key) == value);
    EXPECT_EQ(differences, c.name == "walk" ? 0 : 1) << c.name;
    EXPECT_EQ(c.settings.at("filter").text_or(""), "box");
  }
}

TEST(Configurations, FeaturesThatASceneLacksAreSkippedAndReported) {
  const ConfigurationList list = make_configurations({false, false, 1}, {}, known(), ".");
  const auto all = names(list);
  EXPECT_FALSE(all.count("lambert"));
  EXPECT_FALSE(all.count("walkGuiding=off"));
  EXPECT_TRUE(all.count("refineLevel-1"));
  EXPECT_FALSE(all.count("refineLevel-2"));
  const auto said = [&](const std::string& part) {
    return std::any_of(list.skipped.begin(), list.skipped.end(),
                       [&](const std::string& line) { return line.find(part) != std::string::npos; });
  };
  EXPECT_TRUE(said("lambert: the scene has no subsurface"));
  EXPECT_TRUE(said("textureFilter=0.5: the scene has no images"));
  EXPECT_TRUE(said("refineLevel-2: "));
}

TEST(Configurations, TheSceneDecidesWhereItAsksForMore) {
  const hd::Dictionary scene{{"maxDepth", int64_t(200)}, {"samples", int64_t(9)}, {"targetError", 0.1}};
  const ConfigurationList list = make_configurations({true, false, 0}, scene, known(), "");
  EXPECT_EQ(list.measured.front().settings.at("maxDepth").number_or(0), 200);
  EXPECT_EQ(list.reference.settings.at("maxDepth").number_or(0), 200);
  EXPECT_FALSE(list.measured.front().settings.count("samples"));
  EXPECT_FALSE(list.measured.front().settings.count("targetError"));
}

TEST(Configurations, PresetsAreMeasuredWithoutTheirLimits) {
  const hd::Dictionary scene{{"filter", std::string("box")}, {"maxDepth", int64_t(200)}, {"samples", int64_t(9)}};
  const ConfigurationList list = make_configurations({true, false, 0}, scene, known(), "^quality=");
  const auto& presets = hd::description::QualityPresets();
  ASSERT_EQ(list.measured.size(), 1 + presets.size());
  for (size_t i = 0; i < presets.size(); ++i) {
    hd::Dictionary expected = presets[i].settings;
    for (const char* key : {"samples", "targetError"}) EXPECT_EQ(expected.erase(key), 1u);
    expected.erase("timeLimit");
    expected["filter"] = std::string("box");
    EXPECT_EQ(list.measured[1 + i].name, "quality=" + presets[i].name);
    EXPECT_EQ(list.measured[1 + i].settings, expected);
    EXPECT_EQ(list.measured[1 + i].flags, "--quality " + presets[i].name);
    EXPECT_EQ(list.measured[1 + i].first_samples(), presets[i].settings.contains("adaptive") ? 32u : 1u);
  }
}

TEST(Configurations, OnlySelects) {
  EXPECT_EQ(names(make_configurations({true, false, 0}, {}, known(), "^lambert$|maxDepth")),
            (std::set<std::string>{"walk", "lambert", "maxDepth=2", "maxDepth=4", "maxDepth=8", "maxDepth=16"}));
  EXPECT_EQ(make_configurations({true, false, 0}, {}, known(), "(").measured.size(), 1u)
      << "a faulty pattern matches nothing";
}

}  // namespace
}  // namespace alabaster::tradeoff
