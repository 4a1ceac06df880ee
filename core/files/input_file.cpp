#include "core/files/input_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "core/files/real_path.h"

namespace alabaster {

InputFile::InputFile(const std::string& path, const std::string& within) {
  if (!open(path, within) && descriptor_ >= 0) {
    ::close(descriptor_);
    descriptor_ = -1;
  }
}

InputFile::~InputFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

bool InputFile::fail(Fault fault, const std::string& reason) {
  fault_ = fault;
  reason_ = reason;
  return false;
}

bool InputFile::fail(int error) {
  if (error == ENOENT || error == ENOTDIR)
    return fail(Fault::missing, "there is no such file; correct the path or put the file there");
  std::string remedy = "check its permissions and links";
  if (error == EMFILE || error == ENFILE) remedy = "close files or raise the limit of open files (ulimit -n)";
  if (error == ENOMEM) remedy = "free memory";
  if (error == EIO || error == ESTALE) remedy = "check the disk or the network that holds it";
  if (error == ENAMETOOLONG) remedy = "shorten its name";
  return fail(Fault::unreadable, "it cannot be read: " + std::generic_category().message(error) + "; " + remedy);
}

bool InputFile::open(const std::string& path, const std::string& within) {
  if (path.empty() || path.find('\0') != std::string::npos) return fail(ENOENT);
  const std::string place = within.empty() ? path : real_path(path);
  if (place.empty()) return fail(errno);
  if (!within.empty() && !is_within(place, within)) return fail(Fault::outside, outside_text(place));
  // Opening a FIFO or device may have effects: those that stand there already are left alone.
  struct stat now = {};
  if (::stat(place.c_str(), &now) != 0) return fail(errno);
  constexpr int kFlags = O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC;
  if (S_ISREG(now.st_mode)) {
    descriptor_ = within.empty() ? ::open(place.c_str(), kFlags) : open_real(place, kFlags);
    if (descriptor_ < 0 && errno == ELOOP && !within.empty())
      return fail(Fault::outside, "a link has taken the place of '" + place + "' while it was opened; try again");
    if (descriptor_ < 0 || ::fstat(descriptor_, &now) != 0) return fail(errno);
  }
  if (S_ISDIR(now.st_mode)) return fail(Fault::not_regular, "it is a folder and not a regular file; name a file in it");
  if (!S_ISREG(now.st_mode))
    return fail(Fault::not_regular, "it is not a regular file, and may have no end; name a regular file");
  size_ = static_cast<uint64_t>(now.st_size);
  return true;
}

bool InputFile::read(uint64_t offset, void* out, size_t count) const {
  constexpr size_t kLargestRead = size_t(1) << 30;  // Linux transfers at most 2^31 - 4096 bytes at once
  auto* at = static_cast<char*>(out);
  while (count > 0) {
    const ssize_t got = ::pread(descriptor_, at, std::min(count, kLargestRead), static_cast<off_t>(offset));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    at += got, offset += static_cast<uint64_t>(got), count -= static_cast<size_t>(got);
  }
  return true;
}

}  // namespace alabaster
