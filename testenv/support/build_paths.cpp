#include "testenv/support/build_paths.h"

#include <fstream>
#include <iterator>

namespace alabaster::testing {

std::string source_file(const std::string& below) {
  return ALABASTER_SOURCE_DIR "/" + below;
}
std::string source_text(const std::string& below) {
  std::ifstream file(source_file(below));
  return {std::istreambuf_iterator<char>(file), {}};
}

const char* const kProgram = ALABASTER_PROGRAM;
const char* const kFakeOidn = ALABASTER_FAKE_OIDN;
const char* const kPlainLibrary = ALABASTER_PLAIN_LIBRARY;

}  // namespace alabaster::testing
