#include "core/diagnostics/check.h"

#include <gtest/gtest.h>

#include <locale>
#include <string>

namespace alabaster {
namespace {

std::string message_of(void (*failing)()) {
  try {
    failing();
  } catch (const CheckFailure& failure) {
    return failure.what();
  }
  return "no failure";
}

TEST(Check, NamesTheConditionBothValuesAndThePlace) {
  const std::string comparison = message_of([] {
    const float pdf = -0.25f;
    CHECK_GE(pdf, 0.0f);
  });
  EXPECT_TRUE(comparison.starts_with("check failed: pdf >= 0.0f: -0.25 against 0 (testenv/unit/core/")) << comparison;
  EXPECT_NE(comparison.find("check_test.cpp:"), std::string::npos) << comparison;
  EXPECT_TRUE(message_of([] { CHECK(1 + 1 == 3); }).starts_with("check failed: 1 + 1 == 3 (")) << "without values";
}

TEST(Check, TheHostsLocaleChangesNoNumber) {
  struct Commas : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\3"; }
  };
  const std::locale before = std::locale::global(std::locale(std::locale(), new Commas));
  const std::string message = message_of([] { CHECK_LT(1234567, 0.5); });
  std::locale::global(before);
  EXPECT_NE(message.find(": 1234567 against 0.5 ("), std::string::npos) << message;
}

}  // namespace
}  // namespace alabaster
