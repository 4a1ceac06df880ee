#include "testenv/support/z_test.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

namespace alabaster::testing {

double sidak_level(double significance, int number_of_tests) {
  // expm1/log1p: for many tests (1 - significance)^(1/n) rounds to one.
  return -std::expm1(std::log1p(-significance) / std::max(1, number_of_tests));
}

void RunningStatistics::add(double x) {
  max_ = count_ == 0 ? x : std::max(max_, x);
  ++count_;
  const double delta = x - mean_;
  mean_ += delta / static_cast<double>(count_);
  sum_squares_ += delta * (x - mean_);
}

void RunningStatistics::merge(const RunningStatistics& other) {
  if (other.count_ == 0) return;
  max_ = count_ == 0 ? other.max_ : std::max(max_, other.max_);
  const auto own = static_cast<double>(count_), others = static_cast<double>(other.count_);
  const double delta = other.mean_ - mean_;
  mean_ += delta * (others / (own + others));
  sum_squares_ += other.sum_squares_ + delta * delta * (own * others / (own + others));
  count_ += other.count_;
}

double RunningStatistics::variance() const {
  return count_ < 2 ? 0 : sum_squares_ / static_cast<double>(count_ - 1);
}

double RunningStatistics::standard_error() const {
  return count_ == 0 ? 0 : std::sqrt(variance() / static_cast<double>(count_));
}

ZTestResult z_test(const RunningStatistics& values, double expected, const ZTestOptions& options) {
  ZTestResult result;
  const double difference = std::max(0.0, std::abs(values.mean() - expected) - options.slack);
  const double error = values.standard_error();
  if (difference == 0) {
    result.z = 0;
  } else {
    result.z = error > 0 ? difference / error : std::numeric_limits<double>::infinity();
  }
  result.p_value = std::erfc(result.z / std::sqrt(2.0));
  const double level = sidak_level(options.significance, options.number_of_tests);
  result.passed =
      std::isfinite(values.mean()) && std::isfinite(expected) && values.count() > 1 && result.p_value >= level;
  std::ostringstream text;
  text.precision(8);
  text << "mean " << values.mean() << " +- " << error << ", expected " << expected << " (slack " << options.slack
       << "), n " << values.count() << ", z " << result.z << ", p " << result.p_value << ", level " << level;
  result.report = text.str();
  return result;
}

}  // namespace alabaster::testing
