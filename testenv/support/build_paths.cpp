#include "testenv/support/build_paths.h"

namespace alabaster::testing {

std::string source_file(const std::string& below) {
  return ALABASTER_SOURCE_DIR "/" + below;
}

const char* const kProgram = ALABASTER_PROGRAM;
const char* const kFakeOidn = ALABASTER_FAKE_OIDN;
const char* const kPlainLibrary = ALABASTER_PLAIN_LIBRARY;

}  // namespace alabaster::testing
