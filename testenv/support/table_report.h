// Tables of measurements beside theory, as Markdown: precision, cells, and the verdict. A table may have any number of
// comparisons with theory. All of them together are one family of tests (Sidak), so that a long report does not fail by
// chance.
#pragma once

#include <cmath>
#include <span>
#include <string>
#include <vector>

#include "testenv/support/z_test.h"

namespace alabaster::testing {

/// printf into a string.
[[gnu::format(printf, 1, 2)]] std::string text(const char* format, ...);

/// A measured mean and its standard error.
struct Estimate {
  double mean = 0, sigma = 0;
  Estimate(double m, double s) : mean(m), sigma(s) {}
  Estimate(const RunningStatistics& values) : Estimate(values.mean(), values.standard_error()) {}
  std::string text() const;  // "0.50012 ± 0.00020"
};

class Report {
 public:
  /// `sigma` is the standard error that a table should reach for a quantity between 0 and 1.
  explicit Report(double sigma) : sigma_(sigma) {}

  double sigma() const { return sigma_; }
  /// The number of walks that reduce the standard error of a quantity with this variance to `factor` times sigma().
  uint64_t walks_for(double variance, double factor = 1) const;

  void heading(const std::string& title);
  void paragraph(const std::string& words);
  void columns(const std::vector<std::string>& names);
  void row(const std::vector<std::string>& cells);

  /// The z of a comparison, as a cell; it counts for the verdict. `slack` bounds the error of `expected`.
  std::string z(const Estimate& measured, double expected, double slack = 0);
  /// The same for a share of walks (each counts 0 or 1), with the standard error from theory, which rare events need.
  /// "-", without counting, where fewer than ten are expected.
  std::string z_share(const RunningStatistics& walks, double expected, double slack = 0);
  /// The z of the difference of two independent measurements.
  std::string z_between(const Estimate& measured, const Estimate& other) {
    return z({measured.mean - other.mean, std::hypot(measured.sigma, other.sigma)}, 0);
  }
  /// A requirement. A failure is printed and makes the verdict fail.
  void require(bool holds, const std::string& what);

  /// Prints the number of comparisons and the worst of them. True if the family passes at kFamilyLevel and all
  /// requirements hold.
  bool verdict();

 private:
  double sigma_, worst_ = 0;
  int comparisons_ = 0, above_three_ = 0, failures_ = 0;
};

/// One table: its name on the command line, and the function that prints it.
struct Table {
  const char* name;
  void (*print)(Report& report);
};

/// The main function of a program that prints tables as Markdown:
///   NAME --quick | --long [--table TABLE]...
/// --quick is a tenth of the precision, for the test suite. Returns the exit status: 0 all comparisons hold, 1 some do
/// not, 2 wrong usage.
int print_tables(int argc, char** argv, const char* title, std::span<const Table> tables);

}  // namespace alabaster::testing
