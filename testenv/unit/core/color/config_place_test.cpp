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

TEST(ConfigPlace, AFileLiesInTheFolderThatIsAllowed) {
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

}  // namespace
}  // namespace alabaster
