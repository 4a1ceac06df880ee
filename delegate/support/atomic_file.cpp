#include "delegate/support/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <filesystem>
#include <system_error>

namespace alabaster::hd::support {
namespace {

std::string reason_of(int error) {
  return std::generic_category().message(error);
}

/// Opens a new hidden file next to `file`. No other process or thread makes one of this name.
int open_temporary(const std::filesystem::path& file, std::string& name) {
  static std::atomic<uint64_t> counter{0};
  for (int attempt = 0; attempt < 100; ++attempt) {
    const std::string leaf =
        "." + file.filename().string() + "." + std::to_string(::getpid()) + "-" + std::to_string(counter++) + ".tmp";
    name = (file.parent_path() / leaf).string();
    const int handle = ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (handle >= 0 || errno != EEXIST) return handle;
  }
  return -1;
}

int write_all(int handle, std::span<const uint8_t> bytes, Flush flush) {
  constexpr size_t kLargestWrite = size_t(1) << 30;  // Linux transfers at most 2^31 - 4096 bytes at once
  while (!bytes.empty()) {
    const ssize_t written = ::write(handle, bytes.data(), std::min(bytes.size(), kLargestWrite));
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    bytes = bytes.subspan(size_t(written));
  }
  return flush == Flush::none || ::fsync(handle) == 0 ? 0 : errno;
}

/// The rename must reach the disk too. Some network file systems cannot sync a folder: that is no failure.
void sync_folder(const std::filesystem::path& file) {
  const std::string folder = file.has_parent_path() ? file.parent_path().string() : ".";
  const int handle = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (handle < 0) return;
  static_cast<void>(::fsync(handle));
  ::close(handle);
}

}  // namespace

std::string WriteFileAtomically(const std::string& file, std::span<const uint8_t> bytes, Flush flush) {
  std::string temporary;
  const int handle = open_temporary(file, temporary);
  if (handle < 0) return reason_of(errno);
  int error = write_all(handle, bytes, flush);
  if (::close(handle) != 0 && error == 0) error = errno;
  if (error == 0 && ::rename(temporary.c_str(), file.c_str()) != 0) error = errno;
  if (error != 0) {
    ::unlink(temporary.c_str());
    return reason_of(error);
  }
  if (flush == Flush::disk) sync_folder(file);
  return {};
}

}  // namespace alabaster::hd::support
