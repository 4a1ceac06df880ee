// Tests Monte Carlo means: means and standard errors by Welford's update, and two-sided tests of means, which
// statistics.h decides. Sidak's correction for a family of tests of which any one may fail by chance.
#pragma once

#include <cstdint>
#include <string>

#include "testenv/support/statistics.h"

namespace alabaster::testing {

/// The level at which each of `number_of_tests` independent tests must be run for the family to fail by chance with
/// probability `significance` (Sidak 1967): 1 - (1 - significance)^(1/number_of_tests).
double sidak_level(double significance, int number_of_tests);

class RunningStatistics {
 public:
  void add(double x);
  /// Adds all values of the other one (Chan, Golub and LeVeque 1979).
  void merge(const RunningStatistics& other);
  uint64_t count() const { return count_; }
  double mean() const { return mean_; }
  /// Unbiased; 0 for fewer than two values.
  double variance() const;
  double standard_error() const;
  double max() const { return max_; }

 private:
  uint64_t count_ = 0;
  double mean_ = 0, sum_squares_ = 0, max_ = 0;
};

/// P(|T| >= t) of Student's distribution.
double student_tail(double t, uint64_t degrees_of_freedom);

struct ZTestOptions {
  double slack = 0;  // known bound of the error of `expected` (quadrature, float rounding), which is tolerated
};

struct ZTestResult {
  double z = 0;
  double p_value = 0;  // of this test alone
  std::string report;  // numbers of the test, one line
};

/// The values must be independent; their mean is taken as normally distributed. With zero variance p is 1 if the mean
/// lies within `slack`, else 0. It is 0 for a mean that is not finite, and for fewer than two values.
ZTestResult z_test(const RunningStatistics& values, double expected, const ZTestOptions& options = {});
/// Compares two independent means.
ZTestResult z_test(const RunningStatistics& a, const RunningStatistics& b, const ZTestOptions& options = {});
/// Tests a mean of many values with a known standard error.
ZTestResult z_test(double mean, double standard_error, double expected, const ZTestOptions& options = {});
/// One-sided: that the expected value is no more than `bound`.
ZTestResult at_most_test(const RunningStatistics& values, double bound);

}  // namespace alabaster::testing
