#include "testenv/statistical/tables/report.h"

#include <cmath>
#include <cstdarg>
#include <cstdio>

namespace alabaster::testing {

std::string text(const char* format, ...) {
  char buffer[512];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(buffer, sizeof buffer, format, arguments);
  va_end(arguments);
  return buffer;
}

std::string Estimate::text() const {
  return testing::text("%.5f ± %.5f", mean, sigma);
}

uint64_t Report::walks_for(double variance, double factor) const {
  constexpr double kFewest = 2000;  // with fewer, the mean of rare events is not normally distributed
  return static_cast<uint64_t>(std::max(kFewest, variance / (sigma_ * sigma_ * factor * factor)));
}

void Report::heading(const std::string& title) {
  std::printf("\n## %s\n", title.c_str());
}

void Report::paragraph(const std::string& words) {
  std::printf("\n%s\n", words.c_str());
  std::fflush(stdout);
}

void Report::columns(const std::vector<std::string>& names) {
  std::printf("\n|");
  for (const std::string& name : names) std::printf(" %s |", name.c_str());
  std::printf("\n|");
  for (size_t i = 0; i < names.size(); ++i) std::printf("--|");
  std::printf("\n");
}

void Report::row(const std::vector<std::string>& cells) {
  std::printf("|");
  for (const std::string& cell : cells) std::printf(" %s |", cell.c_str());
  std::printf("\n");
  std::fflush(stdout);
}

std::string Report::z(const Estimate& measured, double expected, double slack) {
  const double difference = measured.mean - expected;
  const double beyond = std::max(0.0, std::abs(difference) - slack);
  double z = beyond == 0 ? 0 : beyond / measured.sigma;
  if (!std::isfinite(z)) z = std::numeric_limits<double>::infinity();
  ++comparisons_;
  above_three_ += z > 3;
  worst_ = std::max(worst_, z);
  return testing::text("%+.1f", std::copysign(z, difference));
}

std::string Report::z_share(const RunningStatistics& walks, double expected, double slack) {
  const auto n = static_cast<double>(walks.count());
  const double variance = expected * (1 - expected);
  if (!(n * variance >= 10)) return "-";
  return z({walks.mean(), std::sqrt(variance / n)}, expected, slack);
}

void Report::require(bool holds, const std::string& what) {
  if (holds) return;
  ++failures_;
  std::printf("\n**FAILED: %s**\n", what.c_str());
}

bool Report::verdict() {
  constexpr double kSignificance = 0.001;
  const double p_value = std::erfc(worst_ / std::sqrt(2.0));
  const bool pass = comparisons_ == 0 || p_value >= sidak_level(kSignificance, comparisons_);
  std::printf(
      "\n## Verdict\n\n%d comparisons with theory, the worst at |z| = %.2f; %d above 3, where chance alone puts ",
      comparisons_, worst_, above_three_);
  std::printf("%.1f. Requirements that failed: %d. %s\n", 0.0027 * comparisons_, failures_,
              pass && failures_ == 0 ? "Passed." : "**FAILED.**");
  return pass && failures_ == 0;
}

}  // namespace alabaster::testing
