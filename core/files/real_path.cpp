#include "core/files/real_path.h"

#include <fcntl.h>
#include <linux/openat2.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <system_error>

namespace alabaster {
namespace {

namespace fs = std::filesystem;

// A link whose file is missing leads to where the file would be made.
fs::path behind_links(fs::path file) {
  constexpr int kMostLinks = 40;
  for (int i = 0; i < kMostLinks; ++i) {
    std::error_code none;
    if (fs::exists(file, none) || !fs::is_symlink(fs::symlink_status(file, none))) return file;
    const fs::path next = fs::read_symlink(file, none);
    file = next.is_absolute() ? next : file.parent_path() / next;
  }
  return file;
}

// The path of an open file as the kernel knows it. Empty without /proc.
std::string path_of(int descriptor) {
  std::error_code error;
  return fs::read_symlink("/proc/self/fd/" + std::to_string(descriptor), error).string();
}

}  // namespace

std::string real_path(const std::string& name) {
  errno = EINVAL;
  if (name.find('\0') != std::string::npos) return {};
  std::error_code error;
  // A name of which no part exists stays relative unless it is made absolute first.
  const fs::path whole = behind_links(fs::absolute(name.empty() ? "." : name, error));
  const fs::path place = error ? fs::path() : fs::weakly_canonical(whole, error);
  errno = error.value();
  if (error) return {};
  // With a last '/', the last part would be empty.
  return (place.has_filename() || !place.has_relative_path() ? place : place.parent_path()).string();
}

std::string allowed_folder(const std::string& folder) {
  const std::string real = real_path(folder);
  return real.empty() ? "?" : real;
}

bool is_within(const std::string& real, const std::string& folder) {
  const fs::path file(real), top(folder);
  return !folder.empty() && std::mismatch(top.begin(), top.end(), file.begin(), file.end()).first == top.end();
}

std::string outside_text(const std::string& real) {
  return "'" + real +
         "' lies outside the folder of the file that names it (links are followed); move it there, or allow it with "
         "--allow-outside (hosts: option allow_outside)";
}

std::string outside_fault(const std::string& folder, const std::string& file) {
  const std::string place = real_path(file);
  if (place.empty())
    return "'" + file + "' cannot be followed: " + std::generic_category().message(errno) +
           "; check its folders and links";
  return is_within(place, folder) ? std::string() : outside_text(place);
}

int open_real(const std::string& real, int flags) {
  open_how how{};
  how.flags = static_cast<uint64_t>(flags) | O_CLOEXEC;
  how.resolve = RESOLVE_NO_SYMLINKS | RESOLVE_NO_MAGICLINKS;
  const long opened = ::syscall(SYS_openat2, AT_FDCWD, real.c_str(), &how, sizeof how);
  if (opened >= 0 || (errno != ENOSYS && errno != EPERM)) return static_cast<int>(opened);
  const int descriptor = ::open(real.c_str(), flags | O_NOFOLLOW | O_CLOEXEC);
  if (descriptor < 0 || path_of(descriptor) == real) return descriptor;
  ::close(descriptor);
  errno = ELOOP;
  return -1;
}

}  // namespace alabaster
