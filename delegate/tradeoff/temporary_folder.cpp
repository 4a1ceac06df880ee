#include "delegate/tradeoff/temporary_folder.h"

#include <cstdlib>
#include <system_error>

#include "core/files/temporary_folder.h"

namespace alabaster::tradeoff {

TemporaryFolder::TemporaryFolder(const std::string& prefix) {
  std::string pattern = temporary_folder() + "/" + prefix + "XXXXXX";
  if (::mkdtemp(pattern.data())) path_ = pattern;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
}

}  // namespace alabaster::tradeoff
