#include "testenv/support/statistics.h"

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <set>
#include <sstream>
#include <vector>

namespace alabaster::testing {
namespace {

constexpr const char* kRepeatVariable = "ALABASTER_STATISTICS_REPEAT";  // lines: the tests of the second run
constexpr uint64_t kSeedStep = 1000003;                                 // more than tests count seeds up by

struct Registry {
  int tests = 0, of_current = 0;  // counted
  std::string current;            // GoogleTest's test
  bool may_repeat = false;        // run_tests_twice() runs
  std::set<std::string> to_repeat;
  std::set<std::string> decided_now;  // in the second run
  uint64_t seed_offset = 0;

  Registry() {
    if (const char* seed = std::getenv("ALABASTER_STATISTICS_SEED"))
      seed_offset = 2 * kSeedStep * std::strtoull(seed, nullptr, 10);
    if (const char* repeated = std::getenv(kRepeatVariable)) {
      seed_offset += kSeedStep;
      std::istringstream lines(repeated);
      for (std::string line; std::getline(lines, line);) decided_now.insert(line);
    }
  }
  bool is_second_run() const { return !decided_now.empty(); }
  std::string next_name() {
    const ::testing::TestInfo* test = ::testing::UnitTest::GetInstance()->current_test_info();
    const std::string name = test ? std::string(test->test_suite_name()) + "." + test->name() : "outside of tests";
    of_current = name == current ? of_current + 1 : 0;
    current = name;
    ++tests;
    return name + "#" + std::to_string(of_current);
  }
};

Registry& registry() {
  static Registry only;
  return only;
}

/// The exit status of this program, run for the tests named.
int run_again(const std::set<std::string>& names) {
  std::string filter, list;
  for (const std::string& name : names) {
    filter += name.substr(0, name.find('#')) + ":";
    list += name + "\n";
  }
  setenv(kRepeatVariable, list.c_str(), 1);
  const std::string argument = "--gtest_filter=" + filter;
  std::vector<char*> arguments{const_cast<char*>("statistics"), const_cast<char*>(argument.c_str()), nullptr};
  pid_t child = 0;
  int status = 0;
  if (posix_spawn(&child, "/proc/self/exe", nullptr, nullptr, arguments.data(), environ) != 0 ||
      waitpid(child, &status, 0) != child)
    return 1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}

}  // namespace

uint64_t seed_offset() {
  return registry().seed_offset;
}

bool is_second_run() {
  return registry().is_second_run();
}

::testing::AssertionResult plausible(double p_value, const std::string& report) {
  Registry& all = registry();
  const std::string name = all.next_name();
  const bool rare = !(p_value >= kRunLevel);
  if (all.is_second_run() ? !all.decided_now.contains(name) : !rare) return ::testing::AssertionSuccess();
  if (!all.is_second_run() && all.may_repeat) {
    std::printf("runs again: %s: %s\n", name.c_str(), report.c_str());
    all.to_repeat.insert(name);
    return ::testing::AssertionSuccess();
  }
  std::printf("%s: %s\n", name.c_str(), report.c_str());
  return rare ? ::testing::AssertionFailure() << report : ::testing::AssertionSuccess();
}

int run_tests_twice() {
  Registry& all = registry();
  all.may_repeat = true;
  int failed = RUN_ALL_TESTS();
  if (all.tests == 0 || all.is_second_run()) return failed;
  std::printf("statistical tests: %d, to run again: %zu, chance of a false alarm: %.2g\n", all.tests,
              all.to_repeat.size(), all.tests * kRunLevel * kRunLevel);
  std::fflush(stdout);
  if (all.tests > kMostTests) {
    std::printf("more statistical tests than the levels of testenv/support/statistics.h are for\n");
    failed = 1;
  }
  return (all.to_repeat.empty() || run_again(all.to_repeat) == 0) ? failed : 1;
}

}  // namespace alabaster::testing
