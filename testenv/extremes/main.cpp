// The renderer where numbers are very large, very small, equal, missing or far away, and prints what it gave as
// Markdown.
//   extremes_tables --quick | --long [--table NAME]...
// --quick (about a minute) runs in the test suite and made testenv/extremes/results/extremes.md, --long
// extremes_long.md. Exit status: 0 all rows hold, 1 some do not, 2 wrong usage.
#include <gtest/gtest.h>

#include "testenv/extremes/rows.h"

namespace alabaster::testing {
namespace {

constexpr Table kTables[] = {{"subsurface", print_subsurface}, {"parameters", print_parameters},
                             {"geometry", print_geometry},     {"lights", print_lights},
                             {"cameras", print_cameras},       {"long_runs", print_long_runs},
                             {"precision", print_precision}};

}  // namespace
}  // namespace alabaster::testing

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);  // the scene builder reports through it
  const int status = alabaster::testing::print_tables(argc, argv, "At numerical extremes", alabaster::testing::kTables);
  return status == 0 && ::testing::UnitTest::GetInstance()->ad_hoc_test_result().Failed() ? 1 : status;
}
