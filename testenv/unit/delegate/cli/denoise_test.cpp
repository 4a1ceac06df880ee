// --denoise of the program, with the fake library.
#include <nlohmann/json.hpp>

#include "testenv/support/oidn.h"
#include "testenv/unit/delegate/cli/run_program.h"
#include "testenv/unit/delegate/description/scene_fixture.h"

namespace alabaster::cli {
namespace {

using alabaster::testing::Environment;
using alabaster::testing::FakeOidn;

class DenoiseProgram : public hd::description::SceneFiles {
 protected:
  void SetUp() override {
    SceneFiles::SetUp();
    write("wax.json", R"({"gltf": [{"file": "lit.gltf"}], "lights": [{"name": "sky", "type": "domeLight"}]})");
  }
  int run(std::vector<std::string> arguments) {
    Program program(folder_, arguments);
    const int code = program.wait();
    err_ = program.err();
    return code;
  }
  std::string err_;
};

#define EXPECT_HAS(text, part) EXPECT_NE((text).find(part), std::string::npos) << "said: " << (text)

TEST_F(DenoiseProgram, WritesAndSaysOfWhichPictureTheNoiseIs) {
  const FakeOidn fake;
  EXPECT_EQ(run({"render", "wax.json", "-o", "a.exr", "-o", "a.png", "--spp", "4", "--size", "16x16", "--denoise"}), 0)
      << err_;
  EXPECT_HAS(err_, "after 4 samples per pixel, before denoising");
  EXPECT_EQ(run({"render", "wax.json", "-o", "b.png", "--spp", "4", "--size", "16x16"}), 0) << err_;
  EXPECT_EQ(err_.find("before denoising"), std::string::npos) << err_;
  EXPECT_EQ(run({"render", "wax.json", "--pixel", "3,3", "--size", "16x16", "--denoise"}), 0) << err_;
}

TEST_F(DenoiseProgram, SaysHowToGetTheLibrary) {
  const Environment nowhere("ALABASTER_OIDN", "/nonexistent");
  EXPECT_EQ(run({"render", "wax.json", "-o", "a.exr", "--spp", "4", "--size", "16x16", "--denoise"}), 4);
  EXPECT_HAS(err_, "pip install");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "a.exr"));
}

TEST_F(DenoiseProgram, TradeoffHasRowsOfDenoisedPictures) {
  const FakeOidn fake("color alone");  // twice as bright: a bias of one
  ASSERT_EQ(run({"tradeoff", "wax.json", "-o", "out", "--budget", "0.1", "--size", "12x8", "--only", "maxDepth=2",
                 "--denoise"}),
            0)
      << err_;
  std::ifstream file(folder_ / "out" / "tradeoff.md");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  EXPECT_HAS(text, "## Denoised");
  EXPECT_HAS(text, "| walk denoised | 4 |");
  EXPECT_HAS(text, "| maxDepth=2 denoised | 1 |");
  EXPECT_HAS(text, " --denoise`");
  std::ifstream numbers(folder_ / "out" / "tradeoff.json");
  const nlohmann::json study = nlohmann::json::parse(numbers);
  for (const auto& row : study.at("rows"))
    if (row.at("group") == "denoised")
      EXPECT_GT(row.at("levelBias").get<double>(), 0.5) << row;
    else
      EXPECT_LT(row.at("levelBias").get<double>(), 0.5) << row;
}

}  // namespace
}  // namespace alabaster::cli
