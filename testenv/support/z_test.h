// Tests Monte Carlo means: means and standard errors by Welford's update, a two-sided z-test, and Sidak's correction
// for a family of tests of which any one may fail by chance.
#pragma once

#include <cstdint>
#include <string>

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

struct ZTestOptions {
  double significance = 0.01;  // chance of a false alarm of the whole family
  int number_of_tests = 1;     // tests in the family
  double slack = 0;  // known bound of the error of `expected` (quadrature, float rounding), which is tolerated
};

struct ZTestResult {
  bool passed = false;
  double z = 0;
  double p_value = 0;  // of this test alone, two-sided
  std::string report;  // numbers of the test, one line
};

/// The values must be independent and many (the mean's distribution is taken as normal). Zero variance passes if the
/// mean lies within `slack`. A non-finite mean fails.
ZTestResult z_test(const RunningStatistics& values, double expected, const ZTestOptions& options = {});

}  // namespace alabaster::testing
