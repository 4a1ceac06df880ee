// render --pixel from outside: the path of a sample, on standard output.
#include <OpenImageIO/imageio.h>

#include <cstdio>

#include "testenv/unit/delegate/cli/run_program.h"
#include "testenv/unit/delegate/description/scene_fixture.h"

namespace alabaster::cli {
namespace {

class PixelTest : public hd::description::SceneFiles {};

TEST_F(PixelTest, PrintsThePathOfTheSampleThatTheFrameTakes) {
  const std::vector<std::string> common{"render", "lit.gltf", "--size", "16x12", "--spp", "1"};
  std::vector<std::string> words = common;
  words.insert(words.end(), {"-o", "a.exr"});
  Program frame(folder_, words);
  ASSERT_EQ(frame.wait(), 0) << frame.err();
  words = common;
  words.insert(words.end(), {"--pixel", "8,6,0"});
  Program pixel(folder_, words);
  ASSERT_EQ(pixel.wait(), 0) << pixel.err();
  const std::string text = pixel.out();
  EXPECT_TRUE(text.starts_with("ray from (")) << text;
  EXPECT_NE(text.find("ends: "), std::string::npos) << text;

  // The colour is the frame's.
  const size_t line = text.find("sample 0 of pixel 8,6: colour (");
  ASSERT_NE(line, std::string::npos) << text;
  float told[3] = {-1, -1, -1};
  ASSERT_EQ(std::sscanf(text.c_str() + line, "sample 0 of pixel 8,6: colour (%f %f %f)", told, told + 1, told + 2), 3);
  const auto input = OIIO::ImageInput::open((folder_ / "a.exr").string());
  ASSERT_TRUE(input);
  std::vector<float> image(16 * 12 * static_cast<size_t>(input->spec().nchannels));
  ASSERT_TRUE(input->read_image(0, 0, 0, input->spec().nchannels, OIIO::TypeDesc::FLOAT, image.data()));
  for (size_t c = 0; c < 3; ++c) {
    const float shown = image[(6 * 16 + 8) * static_cast<size_t>(input->spec().nchannels) + c];
    EXPECT_NEAR(shown, told[c], 1e-3f * std::abs(told[c])) << "channel " << c;
  }
}

TEST_F(PixelTest, NamesThePrimsThatThePathMeets) {
  Program program(folder_, {"render", "lit.gltf", "--size", "16x12", "--spp", "8", "--pixel", "8,6"});
  ASSERT_EQ(program.wait(), 0) << program.err();
  const std::string text = program.out();
  for (int s = 0; s < 8; ++s)
    EXPECT_NE(text.find("sample " + std::to_string(s) + " of pixel 8,6: colour ("), std::string::npos) << text;
  EXPECT_NE(text.find("primId 0 is /"), std::string::npos) << text;
}

TEST_F(PixelTest, BadPixelsAreUsageErrors) {
  for (const char* pixel : {"4", "4,", "4,-3", "1,2,3,4", "a,b", "16,0", "0,12"}) {
    Program program(folder_, {"render", "lit.gltf", "--size", "16x12", "--pixel", pixel});
    EXPECT_EQ(program.wait(), 2) << pixel;
    EXPECT_NE(program.err().find("--pixel: '" + std::string(pixel) + "'"), std::string::npos) << program.err();
  }
}

}  // namespace
}  // namespace alabaster::cli
