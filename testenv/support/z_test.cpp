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

namespace {

constexpr uint64_t kMany = 400;  // degrees of freedom from which Student's distribution is taken as normal

ZTestResult test(double difference, double error, uint64_t degrees_of_freedom, double slack) {
  ZTestResult result;
  const double beyond = std::max(0.0, std::abs(difference) - slack);
  if (beyond > 0) result.z = error > 0 ? beyond / error : std::numeric_limits<double>::infinity();
  result.p_value = std::isfinite(difference) && degrees_of_freedom > 0 ? student_tail(result.z, degrees_of_freedom) : 0;
  std::ostringstream text;
  text.precision(8);
  text << "off by " << difference << " +- " << error << " (slack " << slack << "), degrees of freedom "
       << degrees_of_freedom << ", z " << result.z << ", p " << result.p_value;
  result.report = text.str();
  return result;
}

std::string expectation(double mean, double expected) {
  std::ostringstream text;
  text.precision(8);
  text << "mean " << mean << ", expected " << expected << ", ";
  return text.str();
}

ZTestResult described(const std::string& what, ZTestResult result) {
  result.report = what + result.report;
  return result;
}

}  // namespace

// By the finite series of Abramowitz and Stegun 26.7.3 and 26.7.4.
double student_tail(double t, uint64_t degrees_of_freedom) {
  if (degrees_of_freedom >= kMany) return std::erfc(t / std::sqrt(2.0));
  const auto n = static_cast<double>(degrees_of_freedom);
  if (std::isinf(t)) return 0;
  const double angle = std::atan(t / std::sqrt(n)), c = std::cos(angle), s = std::sin(angle);
  const bool odd = degrees_of_freedom % 2 == 1;
  double sum = 0, term = odd ? c : 1;
  for (double k = odd ? 3 : 2; k <= n; k += 2) {
    sum += term;
    term *= c * c * (k - 1) / k;
  }
  const double within = odd ? 2 / M_PI * (angle + s * sum) : s * sum;
  return std::clamp(1 - within, 0.0, 1.0);
}

ZTestResult z_test(const RunningStatistics& values, double expected, const ZTestOptions& options) {
  const uint64_t freedom = values.count() > 1 ? values.count() - 1 : 0;
  return described(expectation(values.mean(), expected),
                   test(values.mean() - expected, values.standard_error(), freedom, options.slack));
}

ZTestResult z_test(const RunningStatistics& a, const RunningStatistics& b, const ZTestOptions& options) {
  // Welch's degrees of freedom lie above this number.
  const uint64_t fewer = std::min(a.count(), b.count()), freedom = fewer > 1 ? fewer - 1 : 0;
  return described(
      expectation(a.mean(), b.mean()),
      test(a.mean() - b.mean(), std::hypot(a.standard_error(), b.standard_error()), freedom, options.slack));
}

ZTestResult z_test(double mean, double standard_error, double expected, const ZTestOptions& options) {
  return described(expectation(mean, expected), test(mean - expected, standard_error, kMany, options.slack));
}

ZTestResult at_most_test(const RunningStatistics& values, double bound) {
  const uint64_t freedom = values.count() > 1 ? values.count() - 1 : 0;
  const double off = values.mean() - bound, beyond = off > 0 ? off : off * 0;  // what is not finite stays so
  ZTestResult result = test(beyond, values.standard_error(), freedom, 0);
  if (result.z > 0) result.p_value /= 2;
  return described(expectation(values.mean(), bound), result);
}

}  // namespace alabaster::testing
