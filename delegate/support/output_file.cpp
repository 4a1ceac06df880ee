#include "delegate/support/output_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <climits>
#include <filesystem>
#include <functional>
#include <optional>
#include <system_error>

namespace alabaster::hd::support {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kTemporaryPrefix = ".alabaster-", kTemporarySuffix = ".tmp";

std::string reason_of(int error) {
  return std::generic_category().message(error);
}

/// An open file that is closed at the end.
class Handle {
 public:
  explicit Handle(int number) : number_(number) {}
  ~Handle() {
    if (number_ >= 0) ::close(number_);
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  int get() const { return number_; }
  explicit operator bool() const { return number_ >= 0; }
  /// errno, 0 if it closed well.
  int close() {
    const int number = number_;
    number_ = -1;
    return ::close(number) == 0 ? 0 : errno;
  }

 private:
  int number_;
};

/// The file that a name leads to.
struct Target {
  fs::path file;                   // symbolic links followed, so that a rename replaces what they lead to
  std::optional<struct stat> now;  // none: there is no such file
  int error = 0;                   // errno; then nothing else counts
};

Target find_target(const std::string& name) {
  Target target;
  target.file = name;
  struct stat now = {};
  if (::stat(name.c_str(), &now) == 0) {
    target.now = now;
    if (!S_ISREG(now.st_mode)) return target;
    std::error_code error;
    target.file = fs::canonical(name, error);
    target.error = error.value();
    return target;
  }
  target.error = errno == ENOENT ? 0 : errno;
  // A link that leads nowhere: the file is made where it points to.
  constexpr int kMostLinks = 40;
  for (int i = 0; i < kMostLinks; ++i) {
    std::error_code error;
    const fs::path next = fs::read_symlink(target.file, error);
    if (error) return target;
    target.file = next.is_absolute() ? next : target.file.parent_path() / next;
  }
  target.error = ELOOP;
  return target;
}

std::string folder_of(const fs::path& file) {
  return file.has_parent_path() ? file.parent_path().string() : ".";
}

/// Nothing if the kind of file and its mode can be written to. A file without write permission for anybody is kept from
/// root, too.
std::string kind_fault(const struct stat& now, const fs::path& file) {
  if (S_ISDIR(now.st_mode)) return "a folder has this name; choose another name";
  if (S_ISBLK(now.st_mode) || S_ISSOCK(now.st_mode))
    return "it is neither a regular file, a FIFO nor a character device; choose another name";
  if ((now.st_mode & 0222) == 0 || ::access(file.c_str(), W_OK) != 0)
    return "the file is read-only; change its permissions or choose another name";
  return {};
}

/// A file without a name in the folder; -1 where the file system has none.
int open_unnamed(const std::string& folder) {
  return ::open(folder.c_str(), O_WRONLY | O_TMPFILE | O_CLOEXEC, 0666);
}

std::string temporary_name(const std::string& folder) {
  static std::atomic<uint64_t> counter{0};
  return folder + "/" + std::string(kTemporaryPrefix) + std::to_string(::getpid()) + "-" + std::to_string(counter++) +
         std::string(kTemporarySuffix);
}

/// A locked file under a temporary name. The lock vanishes with its process, which tells others that the file is stale.
int open_named(const std::string& folder, std::string& name) {
  for (int attempt = 0; attempt < 100; ++attempt) {
    name = temporary_name(folder);
    const int handle = ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (handle < 0 && errno == EEXIST) continue;
    if (handle < 0) return handle;
    const bool locked = ::flock(handle, LOCK_EX | LOCK_NB) == 0;
    if (!locked && errno != EWOULDBLOCK) return handle;  // a file system without locks
    struct stat now = {};
    if (locked && ::fstat(handle, &now) == 0 && now.st_nlink > 0) return handle;
    ::close(handle);  // somebody took it for stale
  }
  errno = EEXIST;
  return -1;
}

/// Removes what processes that were killed left behind.
void clear_stale(const std::string& folder) {
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    const std::string name = at->path().filename().string();
    if (!name.starts_with(kTemporaryPrefix) || !name.ends_with(kTemporarySuffix)) continue;
    const Handle handle(::open(at->path().c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
    if (handle && ::flock(handle.get(), LOCK_EX | LOCK_NB) == 0) ::unlink(at->path().c_str());
  }
}

/// Writes a file's bytes to an open file. Returns errno, 0 if it went well.
using Writer = std::function<int(int handle)>;

int write_all(int handle, std::span<const uint8_t> bytes) {
  constexpr size_t kLargestWrite = size_t(1) << 30;  // Linux transfers at most 2^31 - 4096 bytes at once
  while (!bytes.empty()) {
    const ssize_t written = ::write(handle, bytes.data(), std::min(bytes.size(), kLargestWrite));
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    bytes = bytes.subspan(size_t(written));
  }
  return 0;
}

/// FIFOs and character devices. Without a reader a FIFO is refused, for nobody might ever come.
std::string write_into(const std::string& file, const Writer& write) {
  Handle handle(::open(file.c_str(), O_WRONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC));
  if (!handle) return errno == ENXIO ? "nothing reads from this FIFO" : reason_of(errno);
  if (::fcntl(handle.get(), F_SETFL, 0) != 0) return reason_of(errno);
  int error = write(handle.get());
  if (const int closed = handle.close(); error == 0) error = closed;
  return error == 0 ? std::string() : reason_of(error);
}

/// Gives the written file its name, which replaces a file of this name at once. `temporary` is its name so far; empty:
/// it has none.
int put_in_place(int handle, std::string temporary, const fs::path& file) {
  if (temporary.empty()) {
    const std::string self = "/proc/self/fd/" + std::to_string(handle);
    if (::linkat(AT_FDCWD, self.c_str(), AT_FDCWD, file.c_str(), AT_SYMLINK_FOLLOW) == 0) return 0;
    if (errno != EEXIST) return errno;
    static_cast<void>(::flock(handle, LOCK_EX | LOCK_NB));
    temporary = temporary_name(folder_of(file));
    if (::linkat(AT_FDCWD, self.c_str(), AT_FDCWD, temporary.c_str(), AT_SYMLINK_FOLLOW) != 0) return errno;
  }
  if (::rename(temporary.c_str(), file.c_str()) == 0) return 0;
  const int error = errno;
  ::unlink(temporary.c_str());
  return error;
}

/// The rename must reach the disk too. Some network file systems cannot sync a folder: that is no failure.
void sync_folder(const std::string& folder) {
  const Handle handle(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (handle) static_cast<void>(::fsync(handle.get()));
}

/// Writes a regular file by way of a new one. Returns errno, 0 if it went well.
int write_new(const Target& target, const Writer& write, Flush flush, bool named) {
  const std::string folder = folder_of(target.file);
  std::string temporary;
  const int number = named ? open_named(folder, temporary) : open_unnamed(folder);
  if (number < 0) return errno;
  const Handle handle(number);
  int error = 0;
  if (target.now) {
    static_cast<void>(::fchown(number, target.now->st_uid, target.now->st_gid));  // where we may
    if (::fchmod(number, target.now->st_mode & 07777) != 0) error = errno;
  }
  if (error == 0) error = write(number);
  if (error == 0 && flush == Flush::disk && ::fsync(number) != 0) error = errno;
  if (error == 0) return put_in_place(number, temporary, target.file);
  if (!temporary.empty()) ::unlink(temporary.c_str());
  return error;
}

int replace_file(const Target& target, const Writer& write, Flush flush) {
  clear_stale(folder_of(target.file));
  // Some systems make files without a name but let nobody name them.
  if (::access("/proc/self/fd", X_OK) == 0) {
    const int error = write_new(target, write, flush, false);
    if (error == 0 || error == ECANCELED) return error;
  }
  return write_new(target, write, flush, true);
}

std::string write_file(const std::string& file, const Writer& write, Flush flush) {
  const Target target = find_target(file);
  // A file that the program's own output goes to (/dev/stdout) is not pulled away from under it.
  for (const int stream : {STDOUT_FILENO, STDERR_FILENO}) {
    struct stat own = {};
    if (!target.now || ::fstat(stream, &own) != 0) continue;
    if (own.st_dev != target.now->st_dev || own.st_ino != target.now->st_ino || !S_ISREG(own.st_mode)) continue;
    const int error = write(stream);
    return error == 0 ? std::string() : reason_of(error);
  }
  if (target.error != 0) return reason_of(target.error);
  if (target.now) {
    const std::string fault = kind_fault(*target.now, target.file);
    if (!fault.empty()) return fault;
    if (!S_ISREG(target.now->st_mode)) return write_into(file, write);
  }
  const int error = replace_file(target, write, flush);
  if (error != 0) return reason_of(error);
  if (flush == Flush::disk) sync_folder(folder_of(target.file));
  return {};
}

}  // namespace

std::string OutputFault(const std::string& file) {
  if (file.empty()) return "the name is empty; give the file a name";
  const Target target = find_target(file);
  const std::string folder = folder_of(target.file);
  std::error_code ignored;
  if (!fs::is_directory(folder, ignored)) return "there is no folder '" + folder + "'; create it or choose another";
  const long longest = ::pathconf(folder.c_str(), _PC_NAME_MAX);
  if (longest > 0 && target.file.filename().string().size() > size_t(longest))
    return "the name is longer than " + std::to_string(longest) + " bytes; shorten it";
  if (target.error != 0) return reason_of(target.error) + "; choose another name";
  if (target.now) {
    const std::string fault = kind_fault(*target.now, target.file);
    if (!fault.empty() || !S_ISREG(target.now->st_mode)) return fault;
  }
  std::string temporary;
  int number = open_unnamed(folder);
  if (number < 0) number = open_named(folder, temporary);
  if (number < 0)
    return "the folder '" + folder + "' cannot be written to (" + reason_of(errno) +
           "); change its permissions or write elsewhere";
  ::close(number);
  if (!temporary.empty()) ::unlink(temporary.c_str());
  return {};
}

std::string WriteOutputFile(const std::string& file, std::span<const uint8_t> bytes, Flush flush) {
  return write_file(
      file, [bytes](int handle) { return write_all(handle, bytes); }, flush);
}

std::string KeepElsewhere(const std::string& file, std::span<const uint8_t> bytes) {
  std::error_code error;
  std::string folder = (fs::temp_directory_path(error) / "alabaster_XXXXXX").string();
  if (error || !::mkdtemp(folder.data())) return {};
  const fs::path kept = fs::path(folder) / fs::path(file).filename();
  if (WriteOutputFile(kept.string(), bytes).empty()) return kept.string();
  fs::remove(folder, error);
  return {};
}

std::string StreamOutputFile(const std::string& file, const std::function<bool(const ByteSink&)>& write, Flush flush) {
  const auto writer = [&write](int handle) {
    int error = 0;
    const ByteSink sink = [&](std::span<const uint8_t> bytes) { return (error = write_all(handle, bytes)) == 0; };
    const bool complete = write(sink);
    return complete || error != 0 ? error : ECANCELED;
  };
  return write_file(file, writer, flush);
}

}  // namespace alabaster::hd::support
