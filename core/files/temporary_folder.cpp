#include "core/files/temporary_folder.h"

#include <cstdlib>

namespace alabaster {

// std::filesystem::temp_directory_path takes a variable that is set and empty for a folder, which does not exist.
std::string temporary_folder() {
  for (const char* name : {"TMPDIR", "TMP", "TEMP", "TEMPDIR"})
    if (const char* value = std::getenv(name); value && *value) return value;
  return "/tmp";
}

}  // namespace alabaster
