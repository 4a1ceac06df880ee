// Statistical tests are counted, and each is decided in the same way, however many a program has.
//
// A test with a p-value below kRunLevel runs once more in a process of its own, with other random numbers and four
// times the samples, and fails if its p-value is below kRunLevel again. Each test fails by chance once in 1e8 changes
// of random numbers, and the kMostTests tests that a program may have once in 1 / kFamilyLevel.
//
// Not thread-safe. $ALABASTER_STATISTICS_SEED=1, 2, ... runs a program with other random numbers.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <string>

namespace alabaster::testing {

inline constexpr double kRunLevel = 1e-4, kFamilyLevel = 1e-4;
inline constexpr int kMostTests = 10000;  // kFamilyLevel / kRunLevel^2

uint64_t seed_offset();
bool is_second_run();

/// `seed`, or another one in the second run.
template <class Integer>
Integer run_seed(Integer seed) {
  return static_cast<Integer>(seed + static_cast<Integer>(seed_offset()));
}
/// `samples`, or four times as many in the second run.
template <class Integer>
Integer run_samples(Integer samples) {
  return is_second_run() ? static_cast<Integer>(4 * samples) : samples;
}

/// Counts a test of the current GoogleTest test. A test must make its statistical tests in the same order each time.
::testing::AssertionResult plausible(double p_value, const std::string& report);
template <class Result>
::testing::AssertionResult plausible(const Result& result) {
  return plausible(result.p_value, result.report);
}

/// For values that are wrong on purpose: their test would run again and then fail. Wrong values must be so wrong
/// that chance does not hide them.
template <class Result>
::testing::AssertionResult noticed(const Result& result) {
  if (result.p_value < kRunLevel) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "not noticed: " << result.report;
}

/// In place of RUN_ALL_TESTS: with the second run.
int run_tests_twice();

}  // namespace alabaster::testing
