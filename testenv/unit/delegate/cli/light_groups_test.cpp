// AOVs of light groups, from outside.
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "testenv/unit/delegate/cli/picture_values.h"
#include "testenv/unit/delegate/cli/run_program.h"
#include "testenv/unit/delegate/description/scene_fixture.h"

namespace alabaster::cli {
namespace {

class LightGroupsOfFiles : public hd::description::SceneFiles {
 protected:
  int run(const std::vector<std::string>& words) {
    Program program(folder_, words);
    const int code = program.wait();
    said_ = program.err();
    return code;
  }
  bool says(const std::string& text) const { return said_.find(text) != std::string::npos; }
  // A patch of wax that glows, a lamp, and a dome without a group; more lights with groups of their own.
  void write_scene(int more = 0) const {
    std::string lights = R"({"name": "sky", "type": "domeLight", "intensity": 0.2},
      {"match": "lamp", "intensity": 30, "position": [1, 1, 2], "lightGroup": "key"})";
    for (int i = 0; i < more; ++i)
      lights += R"(, {"name": "l)" + std::to_string(i) + R"(", "type": "sphereLight", "lightGroup": "g)" +
                std::to_string(i) + "\"}";
    write("scene.json", R"({"models": [{"file": "lit.gltf"}], "settings": {"resolution": [24, 16]}, "materials":
      [{"match": "skin", "set": {"scatterDistance": [0.1, 0.05, 0.02], "emission": [0.1, 0.2, 0.3]}}],
      "meshes": [{"match": "patch", "lightGroup": "glow of wax"}], "lights": [)" +
                            lights + "]}");
  }
  // The channels of a picture whose names begin so.
  std::map<std::string, std::vector<float>> channels(const std::string& file) const {
    std::map<std::string, std::vector<float>> all;
    const auto input = OIIO::ImageInput::open(folder_ / file);
    if (!input) return all;
    const auto& names = input->spec().channelnames;
    const std::vector<float> pixels = pixels_of(folder_ / file);
    for (size_t i = 0; i < pixels.size(); ++i) all[names[i % names.size()]].push_back(pixels[i]);
    return all;
  }
  std::string said_;
};

// promise: pipeline.aov.light_group, pipeline.aov.light_group_sums
TEST_F(LightGroupsOfFiles, AllGroupsAddUpToTheColor) {
  write_scene();
  ASSERT_EQ(run({"render", "scene.json", "--spp", "16", "-o", "a.exr", "--aov", "lightGroup:*"}), 0) << said_;
  const auto all = channels("a.exr");
  ASSERT_EQ(all.size(), 4u + 9u);
  for (const std::string channel : {"R", "G", "B"}) {
    const auto &color = all.at(channel), &none = all.at("lightGroup." + channel),
               &key = all.at("lightGroup_key." + channel), &glow = all.at("lightGroup_glow of wax." + channel);
    for (size_t i = 0; i < color.size(); ++i)
      ASSERT_NEAR(none[i] + key[i] + glow[i], color[i], 0x1p-10 * std::abs(color[i]) + 0x1p-12) << i;  // halves
    for (const auto* group : {&none, &key, &glow})
      EXPECT_GT(std::accumulate(group->begin(), group->end(), 0.0), 1) << channel;
  }
}

// promise: pipeline.aov.light_group_info
TEST_F(LightGroupsOfFiles, InfoListsThem) {
  write_scene();
  const auto said = [&](const std::vector<std::string>& words) {
    Program program(folder_, words);
    EXPECT_EQ(program.wait(), 0) << program.err();
    return program.out();
  };
  const auto groups = nlohmann::json::parse(said({"info", "scene.json", "--json"}))["lightGroups"];
  ASSERT_EQ(groups.size(), 2u) << groups;
  ASSERT_EQ(groups["key"].size(), 1u) << groups;
  EXPECT_EQ(groups["glow of wax"].size(), 1u);
  const std::string text = said({"info", "scene.json"});
  EXPECT_NE(text.find("light groups: 2"), std::string::npos) << text;
  EXPECT_NE(text.find("  key: " + groups["key"][0].get<std::string>() + "\n"), std::string::npos) << text;
}

// A light path expression of a group is its AOV.
TEST_F(LightGroupsOfFiles, ALightPathExpressionIsAGroup) {
  write_scene();
  ASSERT_EQ(run({"render", "scene.json", "--spp", "2", "-o", "a.exr", "--aov", "lpe:C.*<L.'key'>", "--aov",
                 "lpe:C<RD>L=matt"}),
            0)
      << said_;
  ASSERT_EQ(run({"render", "scene.json", "--spp", "2", "-o", "b.exr", "--aov", "lightGroup:key", "--aov",
                 "directDiffuse=matt"}),
            0)
      << said_;
  EXPECT_EQ(channels("a.exr"), channels("b.exr"));
  EXPECT_TRUE(channels("a.exr").contains("matt.R"));
  EXPECT_EQ(run({"render", "scene.json", "-o", "c.exr", "--aov", "lpe:C<RD>S*L"}), 2);
  EXPECT_NE(said_.find("Light path expressions"), std::string::npos) << said_;
}

// promise: pipeline.aov.light_group_parts
TEST_F(LightGroupsOfFiles, PartsMergeToTheFilesOfOneRender) {
  write_scene();
  ASSERT_EQ(run({"render", "scene.json", "--spp", "7", "-o", "whole.exr", "--aov", "lightGroup:*"}), 0) << said_;
  ASSERT_EQ(run({"render", "scene.json", "--samples", "0:3", "--checkpoint", "a", "--aov", "lightGroup:*"}), 0);
  ASSERT_EQ(
      run({"render", "scene.json", "--samples", "3:7", "--checkpoint", "b", "--threads", "1", "--aov", "lightGroup:*"}),
      0)
      << said_;
  ASSERT_EQ(run({"merge", "a", "b", "-o", "sum.exr", "--aov", "lightGroup:*"}), 0) << said_;
  EXPECT_EQ(channels("sum.exr"), channels("whole.exr"));
  ASSERT_EQ(run({"merge", "a", "b", "-o", "key.exr", "--aov", "lightGroup:key"}), 0) << said_;
  EXPECT_EQ(channels("key.exr").at("lightGroup_key.G"), channels("whole.exr").at("lightGroup_key.G"));
  EXPECT_EQ(run({"merge", "a", "b", "-o", "sum.exr", "--aov", "lightGroup:kex"}), 3);
  EXPECT_TRUE(says("the checkpoints have no AOV 'lightGroup:kex'")) << said_;

  // Parts without the light of no group have all of theirs.
  ASSERT_EQ(run({"render", "scene.json", "--samples", "0:3", "--checkpoint", "d", "--aov", "lightGroup:key"}), 0);
  ASSERT_EQ(run({"render", "scene.json", "--samples", "3:7", "--checkpoint", "e", "--aov", "lightGroup:key"}), 0);
  ASSERT_EQ(run({"merge", "d", "e", "-o", "named.exr", "--aov", "lightGroup:*"}), 0) << said_;
  EXPECT_EQ(channels("named.exr").at("lightGroup_key.G"), channels("whole.exr").at("lightGroup_key.G"));
  EXPECT_EQ(channels("named.exr").count("lightGroup.G"), 0u);

  // Goes on to the same bytes, and not with other groups.
  ASSERT_EQ(run({"render", "scene.json", "--spp", "3", "--checkpoint", "c", "-o", "on.exr", "--aov", "lightGroup:*"}),
            0)
      << said_;
  ASSERT_EQ(run({"render", "scene.json", "--spp", "7", "--checkpoint", "c", "--resume", "-o", "on.exr", "--aov",
                 "lightGroup:*"}),
            0)
      << said_;
  EXPECT_EQ(channels("on.exr"), channels("whole.exr"));
  EXPECT_EQ(run({"render", "scene.json", "--spp", "9", "--checkpoint", "c", "--resume", "-o", "on.exr", "--aov",
                 "lightGroup:key"}),
            3);
  EXPECT_TRUE(says("the AOVs were")) << said_;
}

// promise: pipeline.aov.light_group_names
TEST_F(LightGroupsOfFiles, UnknownNamesAreTold) {
  write_scene();
  EXPECT_EQ(run({"render", "scene.json", "--spp", "1", "-o", "a.exr", "--aov", "lightGroup:kez"}), 0);
  EXPECT_TRUE(says("no light or mesh has lightGroup 'kez', and the AOV is black; did you mean 'key'?")) << said_;
}

// promise: pipeline.aov.light_group_most
TEST_F(LightGroupsOfFiles, MoreThan64AreRefused) {
  write_scene(61);  // with light without a group 64
  EXPECT_EQ(run({"render", "scene.json", "--spp", "1", "-o", "a.exr", "--aov", "lightGroup:*"}), 0) << said_;
  EXPECT_EQ(channels("a.exr").size(), 4 + 64 * 3u);
  write_scene(62);
  EXPECT_EQ(run({"render", "scene.json", "--spp", "1", "-o", "b.exr", "--aov", "lightGroup:*"}), 3);
  EXPECT_TRUE(says("the frame has 65 AOVs of light groups, and 64 are the most: name those that you want")) << said_;
}

}  // namespace
}  // namespace alabaster::cli
