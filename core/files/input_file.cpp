#include "core/files/input_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <filesystem>
#include <system_error>

#include "core/files/real_path.h"

namespace alabaster {
namespace {

std::string foreign_reason(const std::string& path) {
  std::error_code none;
  for (size_t begin = 0, end = 0; begin < path.size(); begin = end + 1) {
    end = std::min(path.find('/', begin), path.size());
    const std::string part = path.substr(begin, end - begin);
    if (const std::string reason = foreign_name(part); !reason.empty())
      return std::filesystem::exists(path.substr(0, end), none) ? std::string() : reason;
  }
  return {};
}

}  // namespace

std::string foreign_name(std::string_view part) {
  const std::string_view scheme = part.substr(0, part.find(':'));
  const bool is_word = !scheme.empty() && scheme.size() < part.size() && std::isalpha(uint8_t(scheme[0])) &&
                       std::all_of(scheme.begin(), scheme.end(),
                                   [](char c) { return std::isalnum(uint8_t(c)) || c == '+' || c == '-' || c == '.'; });
  const std::string_view rest = is_word ? part.substr(scheme.size() + 1) : std::string_view();
  const bool ends = is_word && (rest.empty() || rest[0] == '\\' || rest[0] == '/');
  const std::string with_colon = "'" + std::string(scheme) + ":'";
  if (ends && scheme.size() == 1)
    return "it begins with a drive letter, " + with_colon + ", which this system does not have; use a relative path";
  if (scheme == "data" && is_word) return "it is a data URI, which is not read here; save the data as a file";
  if (ends)
    return "it is a URI with the scheme " + with_colon +
           ", and only files are read; save it as a file and use its path";
  if (part.starts_with("\\\\"))
    return "it names a share of Windows, '\\\\...', which this system does not have; use a relative path";
  if (part.find('\\') != std::string_view::npos)
    return "there is no such file, and '\\' does not separate folders on this system; write '/'";
  return {};
}

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

bool InputFile::fail(int error, const std::string& path) {
  const bool is_missing = error == ENOENT || error == ENOTDIR;
  if (is_missing || error == ENAMETOOLONG)
    if (const std::string reason = foreign_reason(path); !reason.empty()) return fail(Fault::foreign, reason);
  if (is_missing) return fail(Fault::missing, "there is no such file; correct the path or put the file there");
  std::string remedy = "check its permissions and links";
  if (error == EMFILE || error == ENFILE) remedy = "close files or raise the limit of open files (ulimit -n)";
  if (error == ENOMEM) remedy = "free memory";
  if (error == EIO || error == ESTALE) remedy = "check the disk or the network that holds it";
  if (error == ENAMETOOLONG) remedy = "shorten its name";
  return fail(Fault::unreadable, "it cannot be read: " + std::generic_category().message(error) + "; " + remedy);
}

bool InputFile::open(const std::string& path, const std::string& within) {
  if (path.empty() || path.find('\0') != std::string::npos) return fail(ENOENT, {});
  const std::string place = within.empty() ? path : real_path(path);
  if (place.empty()) return fail(errno, path);
  if (!within.empty() && !is_within(place, within)) return fail(Fault::outside, outside_text(place));
  // Opening a FIFO or device may have effects: those that stand there already are left alone.
  struct stat now = {};
  if (::stat(place.c_str(), &now) != 0) return fail(errno, path);
  constexpr int kFlags = O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC;
  if (S_ISREG(now.st_mode)) {
    descriptor_ = within.empty() ? ::open(place.c_str(), kFlags) : open_real(place, kFlags);
    if (descriptor_ < 0 && errno == ELOOP && !within.empty())
      return fail(Fault::outside, "a link has taken the place of '" + place + "' while it was opened; try again");
    if (descriptor_ < 0 || ::fstat(descriptor_, &now) != 0) return fail(errno, path);
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
