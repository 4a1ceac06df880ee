// Files that are written while they are rendered.
#include <OpenImageIO/imageio.h>

#include <nlohmann/json.hpp>

#include "testenv/support/oidn.h"
#include "testenv/unit/delegate/cli/picture_values.h"
#include "testenv/unit/delegate/cli/run_program.h"
#include "testenv/unit/delegate/description/scene_fixture.h"

namespace alabaster::cli {
namespace {

class Live : public hd::description::SceneFiles {
 protected:
  double denoised_over_color() const {
    const auto image = OIIO::ImageInput::open(folder_ / "live.exr");
    const std::vector<float> all = pixels_of(folder_ / "live.exr");
    if (!image || all.empty()) return 0;
    const int denoised = image->spec().channelindex("denoised.R"), color = image->spec().channelindex("R");
    double sums[2] = {0, 0};
    for (size_t i = 0; i < all.size(); i += static_cast<size_t>(image->spec().nchannels)) {
      sums[0] += double(all[i + static_cast<size_t>(denoised)]);
      sums[1] += double(all[i + static_cast<size_t>(color)]);
    }
    return sums[0] / sums[1];
  }
  /// The samples per pixel that a file says; 0: there is none, or it is not whole.
  int samples_in(const std::string& name, bool* incomplete) const {
    const auto image = OIIO::ImageInput::open(folder_ / name);
    if (!image) return 0;
    const OIIO::ImageSpec& spec = image->spec();
    std::vector<float> all(static_cast<size_t>(spec.width) * static_cast<size_t>(spec.height) *
                           static_cast<size_t>(spec.nchannels));
    if (!image->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, all.data())) return 0;
    *incomplete = spec.get_int_attribute("alabaster/incomplete", 0) == 1;
    return spec.get_int_attribute("alabaster/samplesDone", 0);
  }
};

// Whenever a viewer reads them they are whole, with more samples each time, and the end is that of a render without.
// promise: pipeline.live, pipeline.live.end, pipeline.live.files
TEST_F(Live, FilesGrowWhileTheyAreRenderedAndEndAsWithout) {
  const std::vector<std::string> frame{"--size", "96x64", "--dome", "0.2", "--aov", "normal", "--set", "seed=3"};
  std::vector<std::string> words{"render",   "patch.gltf", "-o",   "live.exr", "-o",
                                 "live.png", "--live",     "0.05", "--spp",    "1000000"};
  words.insert(words.end(), frame.begin(), frame.end());
  Program program(folder_, words);
  int last = 0, seen = 0;
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (seen < 4 && std::chrono::steady_clock::now() < until) {
    bool incomplete = false;
    const bool is_there = std::filesystem::exists(folder_ / "live.exr");
    const int samples = samples_in("live.exr", &incomplete);
    if (is_there) {
      EXPECT_GT(samples, 0) << "a file that is there is whole";
      EXPECT_TRUE(incomplete);
    }
    EXPECT_GE(samples, last);
    seen += samples > last;
    last = samples;
  }
  EXPECT_EQ(seen, 4) << program.err();
  EXPECT_TRUE(std::filesystem::exists(folder_ / "live.png"));
  program.send(SIGKILL);
  program.wait();
  bool incomplete = false;
  EXPECT_GT(samples_in("live.exr", &incomplete), 0);
  EXPECT_TRUE(incomplete);
  std::vector<std::string> short_words{"render", "patch.gltf", "-o", "live.exr", "--live", "0.02", "--spp", "200"},
      plain{"render", "patch.gltf", "-o", "plain.exr", "--spp", "200"};
  short_words.insert(short_words.end(), frame.begin(), frame.end());
  plain.insert(plain.end(), frame.begin(), frame.end());
  ASSERT_EQ(run_program(folder_, short_words).code, 0);
  ASSERT_EQ(run_program(folder_, plain).code, 0);
  EXPECT_EQ(pixels_of(folder_ / "live.exr"), pixels_of(folder_ / "plain.exr"));
  EXPECT_EQ(samples_in("live.exr", &incomplete), 200);
  EXPECT_FALSE(incomplete);
}

// The denoiser in use doubles the picture.
// promise: pipeline.live.denoised
TEST_F(Live, WhatIsToBeDenoisedIsShownAsItIsRendered) {
  const testing::FakeOidn oidn("color alone");
  Program program(folder_, {"render", "patch.gltf", "-o", "live.exr", "--denoise", "--live", "0.05", "--spp", "1000000",
                            "--size", "48x32", "--dome", "0.2"});
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (!std::filesystem::exists(folder_ / "live.exr") && std::chrono::steady_clock::now() < until)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_NEAR(denoised_over_color(), 1, 1e-2) << program.err();
  std::this_thread::sleep_for(std::chrono::seconds(1));  // a signal before the first progress ends the program at once
  program.interrupt();
  EXPECT_EQ(program.wait(), 130);
  EXPECT_NEAR(denoised_over_color(), 2, 1e-2) << program.err();
}

// promise: pipeline.live.fault
TEST_F(Live, AFileThatCannotBeWrittenMeanwhileDoesNotEndTheRender) {
  std::filesystem::create_directory(folder_ / "out");
  Program program(folder_, {"render", "patch.gltf", "-o", "out/a.exr", "--live", "0.05", "--size", "96x64", "--spp",
                            "1000000", "--dome", "0.2"});
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (!std::filesystem::exists(folder_ / "out/a.exr") && std::chrono::steady_clock::now() < until)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  std::filesystem::remove_all(folder_ / "out");
  EXPECT_TRUE(program.wait_for("The render goes on, and writes its files at its end", 60)) << program.err();
  std::filesystem::create_directory(folder_ / "out");
  std::this_thread::sleep_for(std::chrono::seconds(1));
  program.interrupt();
  EXPECT_EQ(program.wait(), 130) << program.err();
  EXPECT_TRUE(std::filesystem::exists(folder_ / "out/a.exr")) << program.err();
}

TEST_F(Live, WhatWritesNoFilesRefusesIt) {
  for (const std::vector<std::string>& more : {std::vector<std::string>{"-o", "a.exr", "--pixel", "1,1"},
                                               {"--samples", "0:2", "--checkpoint", "c"},
                                               {"-o", "a.exr", "--live", "0"}}) {
    std::vector<std::string> words{"render", "patch.gltf"};
    words.insert(words.end(), more.begin(), more.end());
    if (more.back() != "0") words.insert(words.end(), {"--live", "1"});
    const Outcome refused = run_program(folder_, words);
    EXPECT_EQ(refused.code, 2) << refused.err;
    EXPECT_NE(refused.err.find("--live"), std::string::npos) << refused.err;
  }
}

}  // namespace
}  // namespace alabaster::cli
