// Where a configuration's file must lie, and what kind of file it must be.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "core/color/builtin_config.h"
#include "core/color/color_config.h"
#include "core/files/real_path.h"
#include "testenv/support/reports.h"

namespace alabaster {
namespace {

namespace fs = std::filesystem;

TEST(ConfigPlace, ConfigFileOutsideTheAllowedFolderIsRefused) {
  const fs::path top = fs::temp_directory_path() / ("alabaster_config_place_" + std::to_string(::getpid()));
  fs::create_directories(top / "in");
  std::ofstream(top / "f.ocio") << builtin_config_text();
  std::ofstream(top / "in" / "f.ocio") << builtin_config_text();
  fs::create_symlink("../f.ocio", top / "in" / "link.ocio");
  ASSERT_EQ(::mkfifo((top / "in" / "fifo.ocio").c_str(), 0600), 0);
  const std::string in = allowed_folder((top / "in").string());
  testing::Reports reports;
  EXPECT_TRUE(ColorConfig::load((top / "in" / "f.ocio").string(), reports.sink, in)) << reports.text();
  EXPECT_TRUE(ColorConfig::load((top / "f.ocio").string(), reports.sink)) << reports.text();
  EXPECT_FALSE(ColorConfig::load((top / "f.ocio").string(), reports.sink, in)) << "though it is held";
  EXPECT_FALSE(ColorConfig::load((top / "in" / "link.ocio").string(), reports.sink, in));
  EXPECT_FALSE(ColorConfig::load((top / "in" / "fifo.ocio").string(), reports.sink));
  ASSERT_EQ(reports.all.size(), 3u);
  EXPECT_NE(reports.all[0].text.find("outside the folder"), std::string::npos) << reports.text();
  EXPECT_NE(reports.all[1].text.find("outside the folder"), std::string::npos) << reports.text();
  EXPECT_NE(reports.all[2].text.find("not a file"), std::string::npos) << reports.text();
  fs::remove_all(top);
}

// A configuration that a scene names leads no further than the scene does.
TEST(ConfigPlace, LutsOutsideTheAllowedFolderAreRefused) {
  const fs::path top = fs::temp_directory_path() / ("alabaster_config_luts_" + std::to_string(::getpid()));
  fs::create_directories(top / "in" / "luts");
  for (const fs::path& lut : {top / "out.cube", top / "in" / "luts" / "in.cube"})
    std::ofstream(lut) << "LUT_1D_SIZE 2\n0 0 0\n1 1 1\n";
  fs::create_symlink("../out.cube", top / "in" / "link.cube");
  fs::create_symlink(top / "in" / "luts", top / "in" / "absolute");
  const std::string in = allowed_folder((top / "in").string()), config = (top / "in" / "f.ocio").string();
  const auto load = [&](const std::string& lut, const std::string& within) {
    std::ofstream(config) << "ocio_profile_version: 2\nroles: {default: lin, scene_linear: lin}\n"
                          << "displays: {screen: [!<View> {name: graded, colorspace: lut}]}\ncolorspaces:\n"
                          << "  - !<ColorSpace> {name: lin}\n"
                          << "  - !<ColorSpace> {name: lut, from_scene_reference: !<FileTransform> {src: \"" << lut
                          << "\"}}\n";
    testing::Reports reports;
    const bool is_loaded = ColorConfig::load(config, reports.sink, within) != nullptr;
    EXPECT_EQ(is_loaded, reports.text().find("outside the folder") == std::string::npos) << reports.text();
    return is_loaded;
  };
  for (const std::string& lut :
       {std::string("luts/in.cube"), std::string("absolute/in.cube"), std::string("gone.cube")})
    EXPECT_TRUE(load(lut, in)) << lut;
  for (const std::string& lut : {(top / "out.cube").string(), std::string("../out.cube"), std::string("link.cube")}) {
    EXPECT_TRUE(load(lut, {})) << lut;
    EXPECT_FALSE(load(lut, in)) << lut << ", though it is held";
  }
  fs::remove_all(top);
}

}  // namespace
}  // namespace alabaster
