// Checkpoints and parts of frames, from outside.
#include <OpenImageIO/imageio.h>

#include <cstring>
#include <span>

#include "core/digest/digest.h"
#include "testenv/unit/delegate/cli/picture_values.h"
#include "testenv/unit/delegate/cli/run_program.h"
#include "testenv/unit/delegate/description/scene_fixture.h"

namespace alabaster::cli {
namespace {

class CheckpointTest : public hd::description::SceneFiles {
 protected:
  int run(std::vector<std::string> words) {
    Program program(folder_, words);
    const int code = program.wait();
    said_ = program.err();
    printed_ = program.out();
    return code;
  }
  int render(std::vector<std::string> more) {
    more.insert(more.begin(), {"render", "lit.gltf", "--size", "40x24"});
    return run(std::move(more));
  }
  bool says(const std::string& text) const { return said_.find(text) != std::string::npos; }
  bool exists(const std::string& file) const { return std::filesystem::exists(folder_ / file); }
  std::vector<float> pixels(const std::string& file) const { return pixels_of(folder_ / file); }
  // All attributes of a file but those of time and memory.
  std::map<std::string, std::string> attributes(const std::string& file) const {
    std::map<std::string, std::string> all;
    const auto input = OIIO::ImageInput::open(folder_ / file);
    if (!input) return all;
    for (const auto& attribute : input->spec().extra_attribs) {
      const std::string name = attribute.name().string();
      // A sum of parts has no render that ended.
      if (name != "capDate" && name != "DateTime" && name != "alabaster/endedBy" &&
          name.find("econds") == std::string::npos && name.find("Memory") == std::string::npos)
        all[name] = attribute.get_string();
    }
    return all;
  }
  // The number before " % relative RMSE" in a text.
  static double percent(const std::string& text) {
    const size_t end = text.rfind(" % relative RMSE");
    return end == std::string::npos ? -1 : std::stod(text.substr(text.rfind(' ', end - 1)));
  }
  std::string said_, printed_;
};

// promise: farm.checkpoint.parts, farm.parts.merged, pipeline.cryptomatte.ranks
TEST_F(CheckpointTest, PartsMergeToTheFilesOfOneRender) {
  const auto with_aovs = [](std::vector<std::string> words) {
    for (const char* aov : {"normal", "cryptoObject", "cryptoMaterial", "cryptoAsset", "primId", "materialId"})
      words.insert(words.end(), {"--aov", aov});
    return words;
  };
  ASSERT_EQ(render(with_aovs({"--spp", "11", "-o", "whole.exr", "-o", "whole.png"})), 0) << said_;
  ASSERT_EQ(render(with_aovs({"--samples", "0:5", "--checkpoint", "a"})), 0) << said_;
  ASSERT_EQ(render(with_aovs({"--samples", "5:9", "--checkpoint", "b", "-o", "b.exr", "--threads", "1"})), 0);
  ASSERT_EQ(render(with_aovs({"--samples", "9:11", "--checkpoint", "c"})), 0) << said_;
  EXPECT_TRUE(exists("b.exr")) << "a part's own picture";
  ASSERT_EQ(run(with_aovs({"merge", "b", "a", "c", "-o", "sum.exr", "-o", "sum.png"})), 0) << said_;
  EXPECT_EQ(pixels("sum.exr"), pixels("whole.exr"));
  EXPECT_EQ(pixels("sum.png"), pixels("whole.png"));
  EXPECT_EQ(attributes("sum.exr"), attributes("whole.exr"));
  // OpenImageIO's names of OpenEXR's matrices of floats.
  const auto whole = OIIO::ImageInput::open(folder_ / "whole.exr");
  for (const char* name : {"worldtocamera", "worldtoNDC"})
    EXPECT_TRUE(whole->spec().find_attribute(name, OIIO::TypeMatrix)) << name;
  const auto png = OIIO::ImageInput::open(folder_ / "whole.png");
  EXPECT_EQ(png->spec().get_string_attribute("ImageDescription").find("worldTo"), std::string::npos);

  EXPECT_EQ(run({"merge", "a", "c", "-o", "sum.exr"}), 3);
  EXPECT_TRUE(says("samples 5:9 are missing: no part has them")) << said_;
  EXPECT_EQ(run({"merge", "a", "b"}), 0) << "tells how far they are";
  EXPECT_EQ(run({"merge", "a", "lit.gltf", "-o", "sum.exr"}), 3);
  EXPECT_TRUE(says("it is not a checkpoint")) << said_;
  EXPECT_EQ(run({"merge", "a", "-o", "a"}), 2) << "a part would be overwritten";
  ASSERT_EQ(render(with_aovs({"--samples", "5:9", "--checkpoint", "d", "--seed", "4"})), 0) << said_;
  EXPECT_EQ(run({"merge", "a", "d", "-o", "sum.exr"}), 3);
  EXPECT_TRUE(says("'d' is of another render than 'a': setting seed was 4 and is 0")) << said_;
}

// promise: pipeline.cryptomatte.instances
TEST_F(CheckpointTest, PartsHaveTheMattesOfInstances) {
  std::string many = hd::description::patch_gltf(true, true);
  const std::string node = R"({"name": "patch", "mesh": 0)";
  many.insert(many.find(node) + node.size(),
              R"(, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 0}}})");
  many.insert(many.find(R"("extensionsUsed": [)") + 19, R"("EXT_mesh_gpu_instancing", )");
  write("many.gltf", many);
  write("many.json", R"({"models": [{"file": "many.gltf"}], "meshes": [{"match": "patch", "cryptoInstances": true,
                         "cryptoObject": "tile", "cryptoAsset": "wall"}]})");
  const auto render_many = [&](std::vector<std::string> words) {
    for (const char* word : {"--size", "40x24", "--aov", "cryptoObject", "--aov", "cryptoAsset"}) words.push_back(word);
    words.insert(words.begin(), {"render", "many.json"});
    return run(std::move(words));
  };
  ASSERT_EQ(render_many({"--spp", "7", "-o", "whole.exr"}), 0) << said_;
  ASSERT_EQ(render_many({"--samples", "0:3", "--checkpoint", "a"}), 0) << said_;
  ASSERT_EQ(render_many({"--samples", "3:7", "--checkpoint", "b"}), 0) << said_;
  ASSERT_EQ(run({"merge", "a", "b", "-o", "sum.exr", "--aov", "cryptoObject", "--aov", "cryptoAsset"}), 0) << said_;
  EXPECT_EQ(pixels("sum.exr"), pixels("whole.exr"));
  EXPECT_EQ(attributes("sum.exr"), attributes("whole.exr"));
  bool named = false;
  for (const auto& [name, value] : attributes("sum.exr"))
    named = named || (value.find("\"tile.3\"") != std::string::npos && value.find("\"tile.4\"") == std::string::npos);
  EXPECT_TRUE(named);
}

// Under the limit of 1 MiB that this note sets, the sum of the parts would be refused.
// promise: security.limits
TEST_F(CheckpointTest, ANoteSetsNoLimits) {
  ASSERT_EQ(run({"render", "lit.gltf", "--size", "300x200", "--samples", "0:1", "--checkpoint", "part"}), 0) << said_;
  std::ostringstream text;
  text << std::ifstream(folder_ / "part", std::ios::binary).rdbuf();
  std::string all = text.str();
  const std::string limit = R"(\"memoryLimit\":)";
  const size_t at = all.find(limit);
  ASSERT_NE(at, std::string::npos);
  ASSERT_EQ(all[at + limit.size()], '0');
  all[at + limit.size()] = '1';
  constexpr size_t kMagic = 23, kHead = 16;  // delegate/rendering/checkpoint_file.h
  uint64_t size = 0;
  std::memcpy(&size, &all[kMagic], sizeof size);
  const uint64_t sum = checksum(std::as_bytes(std::span(all).subspan(kMagic + kHead, size)), 0);
  std::memcpy(&all[kMagic + sizeof size], &sum, sizeof sum);
  std::ofstream(folder_ / "part", std::ios::binary | std::ios::trunc) << all;
  EXPECT_EQ(run({"merge", "part", "-o", "sum.exr"}), 0) << said_;
}

// Parts that do not begin at sample 0 are pictures of their own, and the error of the mean of two is the root of the
// sum of their squares, divided by two.
TEST_F(CheckpointTest, CheckpointReportsTheNoiseOfAllItsSamples) {
  const auto noise_of = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"render", "patch.gltf", "--size", "40x24"});  // in the studio, whose lights are large
    EXPECT_EQ(run(std::move(words)), 0) << said_;
    return percent(said_);
  };
  noise_of({"--samples", "0:16", "--checkpoint", "a"});
  const double b = noise_of({"--samples", "16:32", "--checkpoint", "b"});
  const double c = noise_of({"--samples", "32:48", "--checkpoint", "c"});
  const double whole = noise_of({"--spp", "48", "-o", "whole.exr"});
  ASSERT_GT(std::min({b, c, whole}), 0);
  ASSERT_EQ(run({"merge", "a", "b", "c", "absent"}), 0) << said_;
  EXPECT_NE(printed_.find("absent: nothing is saved yet\n3 of 4 parts are whole, and 75 % of the samples are saved\n"),
            std::string::npos)
      << printed_;
  EXPECT_NEAR(percent(printed_), whole, 0.005);
  EXPECT_EQ(printed_.find("about"), std::string::npos) << printed_;
  ASSERT_EQ(run({"merge", "c", "b"}), 0) << said_;
  EXPECT_NE(printed_.find("about"), std::string::npos) << printed_;
  EXPECT_NEAR(percent(printed_), std::hypot(b, c) / 2, 0.01);
  EXPECT_TRUE(printed_.ends_with("after 32 samples per pixel\n")) << printed_;
  ASSERT_EQ(run({"merge", "a", "c"}), 0) << said_;
  EXPECT_TRUE(printed_.ends_with("after 32 samples per pixel\n")) << printed_;

  EXPECT_EQ(run({"merge", "a", "absent", "-o", "sum.exr"}), 3);
  EXPECT_TRUE(says(
      "absent: there is no such file; parts missing: 1 of 2. First render it with --samples A:B --checkpoint absent"))
      << said_;
}

// promise: farm.resume.not_overwritten
TEST_F(CheckpointTest, InterruptedRenderResumes) {
  const std::vector<std::string> words{"--spp", "60000", "--checkpoint", "c", "-o", "x.exr"};
  std::vector<std::string> first{"render", "lit.gltf", "--size", "40x24"};
  first.insert(first.end(), words.begin(), words.end());
  first.insert(first.end(), {"--checkpoint-interval", "0.5"});
  {
    Program program(folder_, first);
    for (int i = 0; i < 2000 && !exists("c"); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    program.interrupt();
    EXPECT_EQ(program.wait(), 130);
    EXPECT_NE(program.err().find("the same command with --resume continues from the checkpoint"), std::string::npos);
  }
  EXPECT_EQ(run(first), 2);
  EXPECT_TRUE(says("'c' is there already: add --resume to continue from it, or remove it")) << said_;
  EXPECT_EQ(render({"--spp", "60000", "--checkpoint", "c", "-o", "x.exr", "--resume", "--max-depth", "2"}), 3);
  EXPECT_TRUE(says("cannot go on from checkpoint 'c': it is of another render: setting maxDepth was 8 and is 2"))
      << said_;
  EXPECT_EQ(run({"merge", "c", "-o", "sum.exr"}), 3);
  EXPECT_TRUE(says("it does not have all samples of its part yet")) << said_;
  EXPECT_EQ(run({"merge", "c"}), 0) << said_;
  EXPECT_NE(printed_.find("of 60000 are saved\n0 of 1 parts are whole"), std::string::npos) << printed_;
  EXPECT_GE(percent(printed_), 0) << printed_;
}

// The presets set adaptive and targetError. Each is killed at several moments and resumed.
// promise: farm.checkpoint
TEST_F(CheckpointTest, AKilledRenderOfAPresetGoesOnToTheSameBytes) {
  for (const std::string preset : {"preview", "draft"}) {
    const std::vector<std::string> all{"render", "patch.gltf", "--size", "48x32", "--quality", preset,
                                       "--aov",  "normal",     "--aov",  "depth", "--aov",     "specular"};
    const auto with = [&](std::vector<std::string> more) {
      more.insert(more.begin(), all.begin(), all.end());
      return more;
    };
    ASSERT_EQ(run(with({"-o", "whole.exr", "--checkpoint", "whole"})), 0) << said_;
    const auto resumed = with({"-o", "x.exr", "--checkpoint", "c", "--checkpoint-interval", "0.001", "--resume"});
    int code = -1;
    for (int kills = 0; code != 0 && kills < 8; ++kills) {
      Program program(folder_, resumed);
      std::this_thread::sleep_for(std::chrono::milliseconds(300 + 100 * kills));
      program.send(SIGKILL);
      code = program.wait();
      ASSERT_TRUE(code == 0 || code == -1) << program.err();
    }
    ASSERT_EQ(run(resumed), 0) << said_;
    EXPECT_EQ(pixels("x.exr"), pixels("whole.exr")) << preset;
    ASSERT_EQ(run({"merge", "whole", "-o", "merged.exr", "--aov", "normal", "--aov", "depth", "--aov", "specular"}), 0);
    EXPECT_EQ(pixels("merged.exr"), pixels("whole.exr")) << preset;
    for (const char* file : {"c", "whole"}) std::filesystem::remove(folder_ / file);
  }
}

// The limit counts the time before, so each command goes on for a while.
// promise: farm.resume.settings
TEST_F(CheckpointTest, ARenderThatTheTimeLimitEndedGoesOnToTheSameBytes) {
  const std::vector<std::string> all{"render", "patch.gltf",    "--size", "48x32", "--target-error", "0.02",
                                     "--set",  "adaptive=true", "--spp",  "400",   "--threads",      "1"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), all.begin(), all.end());
    return more;
  };
  ASSERT_EQ(run(with({"-o", "whole.exr"})), 0) << said_;
  int ended = 0;
  for (const char* limit : {"0.01", "0.02", "0.04", "0.08", "0.15", "0.3", "0.6", "1.2"}) {
    const std::string file = std::string(limit) + ".exr";
    ASSERT_EQ(run(with({"-o", file, "--checkpoint", "c", "--resume", "--time-limit", limit})), 0) << said_;
    ended += pixels(file) != pixels("whole.exr");
    ASSERT_EQ(run({"merge", "c", "-o", "merged.exr"}), 0) << said_;
    EXPECT_EQ(pixels("merged.exr"), pixels(file)) << limit;
  }
  EXPECT_GE(ended, 1) << "the limits were too long to end the render";
  ASSERT_EQ(run(with({"-o", "x.exr", "--checkpoint", "c", "--resume"})), 0) << said_;
  EXPECT_EQ(pixels("x.exr"), pixels("whole.exr"));
}

// promise: farm.resume.frames
TEST_F(CheckpointTest, EachFrameHasItsOwnCheckpoint) {
  const std::vector<std::string> words{"--spp", "2", "--frames", "3:4", "-o", "f.#.exr", "--checkpoint", "f.#.ckpt"};
  ASSERT_EQ(render(words), 0) << said_;
  EXPECT_TRUE(exists("f.3.ckpt") && exists("f.4.ckpt"));
  std::filesystem::remove(folder_ / "f.4.ckpt");
  std::vector<std::string> again = words;
  again.push_back("--resume");
  ASSERT_EQ(render(again), 0) << said_;
  EXPECT_TRUE(says("there is no checkpoint 'f.4.ckpt' yet: the render begins at its first sample")) << said_;
  EXPECT_EQ(render({"--spp", "2", "--frames", "3:4", "-o", "f.#.exr", "--checkpoint", "one"}), 2);
}

// promise: farm.parts.refused
TEST_F(CheckpointTest, FlagsThatContradictAreRefused) {
  const auto refused = [&](std::vector<std::string> words, const std::string& why) {
    words.insert(words.end(), {"-o", "x.exr"});
    EXPECT_EQ(render(words), 2);
    EXPECT_TRUE(says(why)) << said_;
    EXPECT_FALSE(exists("x.exr"));
  };
  refused({"--resume"}, "--resume: It needs --checkpoint FILE");
  refused({"--samples", "0:4"}, "--samples: It needs --checkpoint FILE");
  refused({"--samples", "4:4", "--checkpoint", "c"}, "'4:4' is not a range of samples");
  refused({"--samples", "0:4", "--spp", "4", "--checkpoint", "c"}, "cannot be given with --spp");
  refused({"--samples", "0:4", "--target-error", "0.1", "--checkpoint", "c"},
          "The setting targetError decides from all samples how many there are");
  refused({"--samples", "0:64", "--quality", "draft", "--checkpoint", "c"}, "decides from all samples");
  refused({"--checkpoint", "x.exr"}, "x.exr");
  EXPECT_EQ(render({"--checkpoint", "none/c", "-o", "x.exr"}), 5);
}

}  // namespace
}  // namespace alabaster::cli
