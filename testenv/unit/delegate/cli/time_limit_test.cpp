// Renders that a time limit ends, from outside.
#include <OpenImageIO/imageio.h>

#include <nlohmann/json.hpp>

#include "testenv/unit/delegate/cli/run_program.h"
#include "testenv/unit/delegate/description/scene_fixture.h"

namespace alabaster::cli {
namespace {

#define EXPECT_HAS(text, part) EXPECT_NE((text).find(part), std::string::npos) << "said: " << (text)

using TimeLimitTest = hd::description::SceneFiles;

// The first samples of this frame take longer than the limit.
// promise: security.time_limit, trade_off.ends.time
TEST_F(TimeLimitTest, FrameEndsAtTheTimeLimitAndReportsMissingSamples) {
  Program program(folder_, {"render", "patch.gltf", "--size", "2000x1600", "--threads", "1", "--time-limit", "0.001",
                            "-o", "a.exr", "--aov", "sampleCount", "--stats", "s.json"});
  EXPECT_EQ(program.wait(), 0) << program.err();
  EXPECT_HAS(program.err(), "The time limit ended the render before every pixel had a sample: ");
  EXPECT_HAS(program.err(), " of 3200000 pixels have none");
  const auto stats = nlohmann::json::parse(std::ifstream(folder_ / "s.json"));
  const int64_t without = stats["delegate"][0].value("pixelsWithoutSample", 0);
  EXPECT_LT(stats["phases"]["render"]["wall"].get<double>(), 3) << "on a busy machine";
  const auto exr = OIIO::ImageInput::open(folder_ / "a.exr");
  ASSERT_TRUE(exr) << OIIO::geterror();
  EXPECT_EQ(exr->spec().get_int_attribute("alabaster/pixelsWithoutSample", 0), without);
  EXPECT_EQ(exr->spec().get_int_attribute("alabaster/incomplete", 0), 0);
  const int channels = exr->spec().nchannels, count = exr->spec().channelindex("sampleCount.X");
  ASSERT_GE(count, 0);
  std::vector<float> pixels(size_t(exr->spec().image_pixels()) * size_t(channels));
  ASSERT_TRUE(exr->read_image(0, 0, 0, channels, OIIO::TypeFloat, pixels.data()));
  int64_t zero = 0;
  for (size_t i = size_t(count); i < pixels.size(); i += size_t(channels)) zero += pixels[i] == 0;
  EXPECT_EQ(zero, without);
  EXPECT_GT(without, 0);
}

TEST_F(TimeLimitTest, WithoutALimitAllSamplesAreTaken) {
  for (const char* flag : {"--time-limit", "--target-error"}) {
    const auto done =
        run_program(folder_, {"render", "patch.gltf", "--size", "2x2", flag, "0", "-o", "a.exr", "--stats", "s.json"});
    ASSERT_EQ(done.code, 0) << done.err;
    EXPECT_EQ(nlohmann::json::parse(std::ifstream(folder_ / "s.json"))["samples"]["perPixel"], 64) << flag;
  }
}

TEST_F(TimeLimitTest, HelpAndSchemaSayTheSameOfTheTimeLimit) {
  const auto in_one_line = [](const std::string& text) {
    std::istringstream words(text);
    std::string all, word;
    while (words >> word) all += word + " ";
    return all;
  };
  const std::string help = in_one_line(run_program(folder_, {"render", "--help"}).out);
  const auto schema = nlohmann::json::parse(run_program(folder_, {"schema", "render_settings"}).out);
  const std::string said = in_one_line(schema["properties"]["timeLimit"]["description"].get<std::string>());
  const size_t begin = said.find("A pixel that has no sample"), end = said.find("after the limit");
  ASSERT_TRUE(begin < end && end != std::string::npos) << said;
  EXPECT_HAS(help, said.substr(begin, end - begin));
  EXPECT_HAS(help, "with --target-error or --time-limit 65536");
}

}  // namespace
}  // namespace alabaster::cli
