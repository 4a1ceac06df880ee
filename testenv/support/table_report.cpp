#include "testenv/support/table_report.h"

#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <cstring>

namespace alabaster::testing {
namespace {

// Standard errors of quantities between 0 and 1.
constexpr double kQuickSigma = 2e-3, kLongSigma = 2e-4;

const Table* find_table(std::span<const Table> tables, const char* name) {
  for (const Table& table : tables)
    if (std::strcmp(table.name, name) == 0) return &table;
  return nullptr;
}

int usage(const char* program, std::span<const Table> tables) {
  std::fprintf(stderr, "usage: %s --quick | --long [--table NAME]...\ntables:", program);
  for (const Table& table : tables) std::fprintf(stderr, " %s", table.name);
  std::fprintf(stderr, "\n");
  return 2;
}

}  // namespace

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
  const double p_value = std::erfc(worst_ / std::sqrt(2.0));
  const bool pass = comparisons_ == 0 || p_value >= sidak_level(kFamilyLevel, comparisons_);
  std::printf(
      "\n## Verdict\n\n%d comparisons with theory, the worst at |z| = %.2f; %d above 3, where chance alone puts ",
      comparisons_, worst_, above_three_);
  std::printf("%.1f. Requirements that failed: %d. %s\n", 0.0027 * comparisons_, failures_,
              pass && failures_ == 0 ? "Passed." : "**FAILED.**");
  return pass && failures_ == 0;
}

int print_tables(int argc, char** argv, const char* title, std::span<const Table> tables) {
  const char* const slash = std::strrchr(argv[0], '/');
  const char* const program = slash ? slash + 1 : argv[0];
  double sigma = 0;
  std::vector<const Table*> wanted;
  std::string command = std::string("build/release/bin/") + program;
  for (int i = 1; i < argc; ++i) {
    command += std::string(" ") + argv[i];
    if (std::strcmp(argv[i], "--quick") == 0) {
      sigma = kQuickSigma;
    } else if (std::strcmp(argv[i], "--long") == 0) {
      sigma = kLongSigma;
    } else if (std::strcmp(argv[i], "--table") == 0 && i + 1 < argc && find_table(tables, argv[i + 1])) {
      wanted.push_back(find_table(tables, argv[++i]));
      command += std::string(" ") + argv[i];
    } else {
      return usage(program, tables);
    }
  }
  if (!(sigma > 0)) return usage(program, tables);
  if (wanted.empty())
    for (const Table& table : tables) wanted.push_back(&table);

  std::printf("# %s\n\nMade by `%s`.\n", title, command.c_str());
  Report report(sigma);
  for (const Table* table : wanted) table->print(report);
  return report.verdict() ? 0 : 1;
}

}  // namespace alabaster::testing
