// The main function of GoogleTest programs with statistical tests.
#include "testenv/support/statistics.h"

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  return alabaster::testing::run_tests_twice();
}
