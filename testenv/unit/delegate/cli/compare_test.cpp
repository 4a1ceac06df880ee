// alabaster compare: variants of a scene on one sheet.
#include <cmath>

#include "testenv/unit/delegate/cli/picture_values.h"
#include "testenv/unit/delegate/cli/run_program.h"
#include "testenv/unit/delegate/description/scene_fixture.h"

namespace alabaster::cli {
namespace {

constexpr int kWidth = 24, kHeight = 16, kScale = 12;  // of a tile, and its enlarged pixels
constexpr int kGap = 10, kCaption = 44;

class Compare : public hd::description::SceneFiles {
 protected:
  int run(std::vector<std::string> arguments) {
    Program program(folder_, arguments);
    const int code = program.wait();
    err_ = program.err();
    return code;
  }
  int compare(const std::string& scene, const std::vector<std::string>& looks,
              const std::string& output = "sheet.png") {
    std::vector<std::string> words{"compare", scene, "-o", output, "--size", "24x16", "--spp", "4"};
    for (const std::string& look : looks) words.insert(words.end(), {"--look", look});
    return run(words);
  }
  /// The pixels of a tile, read in the middle of what each was enlarged to.
  std::vector<float> tile(int number) const {
    const auto input = OIIO::ImageInput::open(folder_ / "sheet.png");
    if (!input) return {};
    const int width = input->spec().width, channels = input->spec().nchannels;
    const std::vector<float> sheet = pixels_of(folder_ / "sheet.png");
    std::vector<float> pixels;
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const int left = kGap + number * (kWidth * kScale + kGap) + x * kScale + kScale / 2;
        const int top = kGap + kCaption + y * kScale + kScale / 2;
        for (int c = 0; c < 3; ++c) pixels.push_back(sheet[size_t((top * width + left) * channels + c)]);
      }
    return pixels;
  }
  std::string err_;
};

#define EXPECT_HAS(text, part) EXPECT_NE((text).find(part), std::string::npos) << "said: " << (text)

// promise: artists.compare
TEST_F(Compare, EachTileIsThePictureOfItsLook) {
  write("lit.json", R"({"models": [{"file": "lit.gltf"}], "lights": [{"name": "sky", "type": "domeLight"}]})");
  const std::string red = "red: materials/skin.baseColor=[1,0,0]; lights/sky.intensity=0.7";
  ASSERT_EQ(compare("lit.json", {"as it is:", "again:", red}), 0) << err_;
  EXPECT_HAS(err_, "as it is: noise ");
  EXPECT_HAS(err_, "red: noise ");
  EXPECT_EQ(tile(0), tile(1)) << "the sheet has one exposure";
  EXPECT_NE(tile(0), tile(2));
  const struct {
    int tile;
    std::vector<std::string> words;
  } rendered[] = {{0, {}}, {2, {"--set", "materials/skin.baseColor=[1,0,0]", "--set", "lights/sky.intensity=0.7"}}};
  for (const auto& [number, words] : rendered) {
    std::vector<std::string> all{"render", "lit.json", "-o", "a.png", "--size", "24x16", "--spp", "4"};
    all.insert(all.end(), words.begin(), words.end());
    ASSERT_EQ(run(all), 0) << err_;
    const std::vector<float> shown = tile(number), picture = pixels_of(folder_ / "a.png");
    ASSERT_EQ(picture.size(), shown.size() / 3 * 4);
    size_t compared = 0;
    for (size_t i = 0; i < shown.size() / 3; ++i) {
      const float alpha = picture[4 * i + 3];
      if (alpha > 0 && alpha < 1) continue;  // the sheet shows the picture over black, and a PNG without it
      ++compared;
      for (size_t c = 0; c < 3; ++c)
        ASSERT_NEAR(shown[3 * i + c], picture[4 * i + c], 1.5f / 255) << number << " " << i;
    }
    EXPECT_GT(compared, shown.size() / 6);
  }
}

// promise: artists.compare
TEST_F(Compare, AllLooksHaveTheViewOfTheFirst) {
  write("two.json",
        R"({"models": [{"file": "patch.gltf"}, {"file": "patch.gltf", "transform": {"translate": [4, 0, 0]}}],
    "lights": [{"name": "sky", "type": "domeLight"}]})");
  ASSERT_EQ(compare("two.json", {"both:", "one: meshes//copy2/*.visible=false"}), 0) << err_;
  const std::vector<float> both = tile(0), one = tile(1);
  size_t lit = 0, alike = 0, differing = 0;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const size_t i = size_t(3 * (y * kWidth + x));
      const bool is_left = x<kWidth / 2, was_lit = both[i]> 0.1f, is_lit = one[i] > 0.1f;
      lit += is_left && is_lit, alike += is_left && was_lit == is_lit, differing += !is_left && was_lit != is_lit;
    }
  EXPECT_GT(lit, 10u);
  EXPECT_EQ(alike, size_t(kWidth / 2 * kHeight)) << "the patch that stays stands where it stood";
  EXPECT_GT(differing, 10u);
}

TEST_F(Compare, WhatIsWrongIsToldBeforeAnythingIsRendered) {
  const std::vector<std::string> good{"a:", "b:"};
  EXPECT_EQ(compare("lit.gltf", {"a:"}), 2);
  EXPECT_HAS(err_, "Name two variants at least");
  EXPECT_EQ(compare("lit.gltf", {"a:", "materials/skin.roughness=0.5"}), 2);
  EXPECT_HAS(err_, "write 'NAME: KEY=VALUE; KEY=VALUE'");
  EXPECT_EQ(compare("lit.gltf", {"a:", "b: materials/skni.roughness=0.5"}), 2);
  EXPECT_HAS(err_, "--look b: materials/skni.roughness=0.5: No material matches 'skni'. Did you mean 'skin'?");
  EXPECT_EQ(compare("lit.gltf", {"a:", "b: materials/skin.roughness"}), 2);
  EXPECT_HAS(err_, "is not an assignment");
  EXPECT_EQ(compare("lit.gltf", good, "sheet.jpg"), 2);
  EXPECT_HAS(err_, "is no .png file");
  EXPECT_EQ(compare("lit.gltf", good, "absent/sheet.png"), 5);
  EXPECT_EQ(compare("absent.gltf", good), 3);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "sheet.png"));
}

}  // namespace
}  // namespace alabaster::cli
