// render --pixel from outside: the path of a sample, on standard output.
#include <OpenImageIO/imageio.h>

#include <cstdio>

#include "testenv/support/build_paths.h"
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
  for (const char* pixel : {"4", "4,", "4,-3", "1,2,3,4", "1,2,-3", "a,b", "16,0", "0,12"}) {
    Program program(folder_, {"render", "lit.gltf", "--size", "16x12", "--pixel", pixel});
    EXPECT_EQ(program.wait(), 2) << pixel;
    EXPECT_NE(program.err().find("--pixel: '" + std::string(pixel) + "'"), std::string::npos) << program.err();
  }
}

TEST_F(PixelTest, IsPrintedForEachFrameThatHasIt) {
  write("scene.json", R"({"gltf": [{"file": "lit.gltf"}], "settings": {"resolution": [16, 12], "samples": 1},
    "products": [{"file": "one.exr"}, {"file": "two.exr", "resolution": [32, 24]}]})");
  Program both(folder_, {"render", "scene.json", "--pixel", "4,3,0"});
  ASSERT_EQ(both.wait(), 0) << both.err();
  const size_t one = both.out().find("frame of 16x12, for "), two = both.out().find("frame of 32x24, for ");
  ASSERT_TRUE(one != std::string::npos && two != std::string::npos) << both.out();
  const std::string first = both.out().substr(one, two - one), second = both.out().substr(two);
  EXPECT_NE(first.substr(first.find('\n')), second.substr(second.find('\n'))) << "two cameras of two resolutions";
  Program larger(folder_, {"render", "scene.json", "--pixel", "20,3,0"});
  ASSERT_EQ(larger.wait(), 0) << larger.err();
  EXPECT_TRUE(larger.out().starts_with("frame of 32x24, for ")) << larger.out();
  Program none(folder_, {"render", "scene.json", "--pixel", "32,3"});
  EXPECT_EQ(none.wait(), 2);
  EXPECT_NE(none.err().find("'32,3' lies outside the frame of 16x12 and of 32x24."), std::string::npos) << none.err();
}

// The light of dome and surface adds up to more than a float holds; the file's name is one that a shell takes apart.
TEST_F(PixelTest, ASampleThatIsNotFiniteIsShownByTheCommandThatIsPrinted) {
  write("it's $HOME.json", R"({"gltf": [{"file": "patch.gltf"}], "settings": {"resolution": [16, 12]},
    "camera": {"lookAt": {"eye": [0, 0, 2], "target": [0, 0, 0]}},
    "lights": [{"name": "sky", "type": "domeLight", "color": [3e38, 3e38, 3e38]}],
    "materials": [{"match": "*", "set": {"emission": [3.4028234e38, 3.4028234e38, 3.4028234e38]}}]})");
  std::filesystem::create_symlink(testing::kProgram, folder_ / "alabaster");
  for (const char* crop : {"0,0,16,12", "-6,-5,3,3"}) {  // the frame; overscan
    Program frame(folder_, {"render", "-o", "a.exr", "--spp", "2", "--crop", crop, "--", "it's $HOME.json"});
    ASSERT_EQ(frame.wait(), 0) << frame.err();
    const std::string said = frame.err(),
                      lead = "warning: A sample was not finite; the picture has black in its place.";
    ASSERT_NE(said.find(lead), std::string::npos) << said;
    const size_t command = said.find("  alabaster render --pixel ");
    ASSERT_NE(command, std::string::npos) << said;
    const std::string line = said.substr(command + 2, said.find('\n', command) - command - 2);
    const std::string shell = "cd " + folder_.string() + " && ./" + line + " > path.txt";
    ASSERT_EQ(std::system(shell.c_str()), 0) << shell;
    std::ifstream file(folder_ / "path.txt");
    const std::string path{std::istreambuf_iterator<char>(file), {}};
    EXPECT_NE(path.find("not finite: the film takes black in its place"), std::string::npos) << shell << "\n" << path;
  }
}

}  // namespace
}  // namespace alabaster::cli
