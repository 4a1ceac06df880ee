// The module's door: delegate_conformance loads the library under test first and then this.
#include <gtest/gtest.h>

#include "testenv/conformance/host.h"

namespace conformance {
namespace {
Library loaded;
}
const Library& library() {
  return loaded;
}
}  // namespace conformance

extern "C" __attribute__((visibility("default"))) int RunConformanceSuite(int argc, char** argv,
                                                                          const conformance::Library* library) {
  conformance::loaded = *library;
  testing::InitGoogleTest(&argc, argv);
  if (argc > 1) {
    std::fprintf(stderr, "delegate_conformance: unknown option %s\n", argv[1]);
    return 2;
  }
  return RUN_ALL_TESTS();
}
