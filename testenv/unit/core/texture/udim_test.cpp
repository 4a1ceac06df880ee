#include "core/texture/udim.h"

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "core/files/real_path.h"
#include "core/texture/texture.h"
#include "testenv/support/reports.h"

namespace alabaster {
namespace {

namespace fs = std::filesystem;

class Udim : public ::testing::Test {
 protected:
  Udim() { fs::create_directories(folder_); }
  ~Udim() override { fs::remove_all(folder_); }

  // Two texels, left and right.
  void write(const std::string& name, float left, float right) const {
    const std::vector<float> pixels{left, left, left, right, right, right};
    const auto out = OIIO::ImageOutput::create("x.exr");
    ASSERT_TRUE(out->open((folder_ / name).string(), OIIO::ImageSpec(2, 1, 3, OIIO::TypeFloat)) &&
                out->write_image(OIIO::TypeFloat, pixels.data()) && out->close());
  }
  std::shared_ptr<const Texture> load(const std::string& name, bool may_be_set = true) {
    TextureSource source;
    source.path = (folder_ / name).string();
    source.may_be_set = may_be_set;
    reports_.all.clear();
    return load_texture(source, *ColorConfig::load("built-in", {}), reports_.sink);
  }

  fs::path folder_ = fs::temp_directory_path() / ("alabaster_udim_" + std::to_string(::getpid()));
  testing::Reports reports_;
};

TEST_F(Udim, FindsTheFilesByTheirNumbers) {
  for (const char* name : {"skin.1001.exr", "skin.1012.exr", "skin.1010.exr", "skin.1000.exr", "skin.11.exr",
                           "skin.10x1.exr", "skin.1001.png", "bone.1001.exr"})
    std::ofstream(folder_ / name) << "x";
  const auto tiles = udim_tiles((folder_ / "skin.<UDIM>.exr").string());
  ASSERT_EQ(tiles.size(), 3u);
  EXPECT_EQ(tiles[0].place, Vec2i(0, 0));
  EXPECT_EQ(tiles[1].place, Vec2i(9, 0));
  EXPECT_EQ(tiles[2].place, Vec2i(1, 1));
  EXPECT_EQ(tiles[2].path, (folder_ / "skin.1012.exr").string());
  EXPECT_TRUE(udim_tiles((folder_ / "skin.1001.exr").string()).empty());
  EXPECT_TRUE(udim_tiles((folder_ / "none" / "skin.<UDIM>.exr").string()).empty());
}

// A tile is judged by its own name: the pattern names no file.
TEST_F(Udim, ATileOutsideTheAllowedFolderIsRefused) {
  fs::create_directories(folder_ / "in");
  write("in/a.1001.exr", 1, 2);
  write("in/linked.exr", 3, 4);
  write("secret.exr", 5, 6);
  fs::create_symlink(folder_ / "in" / "linked.exr", folder_ / "in" / "a.1002.exr");
  TextureSource source;
  source.path = (folder_ / "in" / "a.<UDIM>.exr").string();
  source.may_be_set = true;
  source.within = allowed_folder((folder_ / "in").string());
  const auto loaded = [&] {
    return load_texture(source, *ColorConfig::load("built-in", {}), reports_.sink) != nullptr;
  };
  EXPECT_TRUE(loaded()) << reports_.text();
  fs::create_symlink("../secret.exr", folder_ / "in" / "a.1003.exr");
  EXPECT_FALSE(loaded());
  EXPECT_NE(reports_.text().find("outside the folder"), std::string::npos) << reports_.text();
  EXPECT_FALSE(is_image(source, reports_.sink));
  source.within.clear();
  EXPECT_TRUE(loaded()) << reports_.text();
}

TEST_F(Udim, EachSquareShowsItsOwnImage) {
  write("a.1001.exr", 1, 2);
  write("a.1002.exr", 3, 4);
  write("a.1011.exr", 5, 6);
  const auto t = load("a.<UDIM>.exr");
  ASSERT_TRUE(t) << reports_.text();
  EXPECT_EQ(t->rgb({0.25f, 0.5f}).r, 1);
  EXPECT_EQ(t->rgb({0.75f, 0.5f}).r, 2);
  EXPECT_EQ(t->rgb({0.5f, 0.5f}).r, 1.5f);
  EXPECT_EQ(t->rgb({1.25f, 0.5f}).r, 3);
  EXPECT_EQ(t->rgb({0.75f, 1.5f}).r, 6);
  EXPECT_EQ(t->rgb({0.999f, 0.5f}).r, 2) << "clamped: not mixed with the neighbour";
  EXPECT_EQ(t->rgb({1.999f, 1}).r, 4) << "the upper border of a square without a neighbour above";
  EXPECT_TRUE(t->is_set() && t->covers({2, 1}) && t->covers({1, 2}));
  for (const Vec2f& outside :
       {Vec2f(1.5f, 1.5f), Vec2f(-0.5f, 0.5f), Vec2f(0.5f, 2.5f), Vec2f(3e9f, 0), Vec2f(NAN, 0)}) {
    EXPECT_FALSE(t->covers(outside));
    EXPECT_EQ(t->rgb(outside), Rgb(0.0f));
    EXPECT_EQ(t->alpha(outside), 0);
    EXPECT_EQ(t->filtered(outside, 4), Rgb(0.0f));
  }
  ASSERT_TRUE(t->prepare_filtering());
  EXPECT_EQ(t->filtered({1.3f, 0.5f}, 100).r, 3.5f);
}

TEST_F(Udim, AMissingOrBrokenImageIsAnErrorAsAnywhere) {
  EXPECT_FALSE(load("a.<UDIM>.exr"));
  EXPECT_NE(reports_.text().find("no such file"), std::string::npos) << reports_.text();
  write("a.1001.exr", 1, 2);
  EXPECT_FALSE(load("a.<UDIM>.exr", false)) << "lights have no sets";
  std::ofstream(folder_ / "a.1002.exr") << "no image";
  EXPECT_FALSE(load("a.<UDIM>.exr"));
  ASSERT_EQ(reports_.all.size(), 1u);
  EXPECT_EQ(reports_.all[0].where, (folder_ / "a.1002.exr").string());
}

}  // namespace
}  // namespace alabaster
