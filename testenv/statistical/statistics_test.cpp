// Statistical tests run again after a rare value, and fail after a second one.
#include "testenv/support/statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "testenv/support/oidn.h"
#include "testenv/support/z_test.h"

namespace alabaster::testing {
namespace {

constexpr const char* kProbe = "ALABASTER_STATISTICS_PROBE";

// The tests below run it in a process of its own.
TEST(StatisticsProbe, FailsInTheRunsThatTheEnvironmentNames) {
  const std::string rare = std::getenv(kProbe) ? std::getenv(kProbe) : "never";
  EXPECT_TRUE(plausible(1, "another test"));
  EXPECT_TRUE(plausible(rare == "in both runs" || (rare == "in the first run" && !is_second_run()) ? 0 : 1, "probe"));
}

bool probe_passes(const std::string& rare) {
  const Environment told(kProbe, rare);
  const std::string program = std::filesystem::read_symlink("/proc/self/exe").string();
  return std::system(("'" + program + "' --gtest_filter=StatisticsProbe.* >/dev/null").c_str()) == 0;
}

TEST(Statistics, TestFailsOnlyIfBothRunsAreRare) {
  EXPECT_TRUE(probe_passes("never"));
  EXPECT_TRUE(probe_passes("in the first run"));
  EXPECT_FALSE(probe_passes("in both runs"));
}

TEST(Statistics, TheLevelsKeepTheFamilysLevel) {
  EXPECT_LE(kMostTests * kRunLevel * kRunLevel, kFamilyLevel);
}

TEST(Statistics, StudentsDistribution) {
  EXPECT_NEAR(student_tail(1, 1), 0.5, 1e-12);
  EXPECT_NEAR(student_tail(2, 2), 1 - 2 / std::sqrt(6.0), 1e-12);
  EXPECT_NEAR(student_tail(2.228138852, 10), 0.05, 1e-9);  // quantiles of tables
  EXPECT_NEAR(student_tail(2.068657610, 23), 0.05, 1e-9);
  EXPECT_NEAR(student_tail(3.9, 399), student_tail(3.9, 400), 3e-5);
  EXPECT_EQ(student_tail(0, 5), 1);
}

TEST(Statistics, BoundsAreOneSided) {
  RunningStatistics values;
  for (int i = 0; i < 1000; ++i) values.add(i % 2);
  EXPECT_TRUE(plausible(at_most_test(values, 0.5)));
  EXPECT_TRUE(plausible(at_most_test(values, 0.6)));
  EXPECT_TRUE(noticed(at_most_test(values, 0.4)));
  EXPECT_TRUE(noticed(at_most_test(values, std::nan(""))));
}

}  // namespace
}  // namespace alabaster::testing
