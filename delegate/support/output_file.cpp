#include "delegate/support/output_file.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <filesystem>
#include <memory>
#include <optional>
#include <system_error>

#include "core/files/real_path.h"

namespace alabaster::hd::support {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kTemporaryPrefix = ".alabaster-", kTemporarySuffix = ".tmp";

std::string reason_of(int error) {
  return std::generic_category().message(error);
}

/// The remedy for an errno of a folder or a file that cannot be opened for writing.
std::string remedy_of(int error) {
  switch (error) {
    case EACCES:
    case EPERM:
      return "change its permissions or write elsewhere";
    case ENOSPC:
    case EDQUOT:
      return "free space there or write elsewhere";
    case EMFILE:
    case ENFILE:
      return "close files or raise the limit of open files (ulimit -n)";
    case ENOMEM:
      return "free memory";
    case ELOOP:
      return "correct the links or choose another name";
    case EROFS:
      return "write elsewhere";
    default:
      return "choose another name";
  }
}

std::string folder_fault(const std::string& folder, int error) {
  if (error == ENOENT) return "there is no folder '" + folder + "'; create it or choose another";
  if (error == ENOTDIR) return "'" + folder + "' is a file and not a folder; choose another";
  return "the folder '" + folder + "' cannot be opened (" + reason_of(error) + "); " + remedy_of(error);
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
  std::string outside;             // why the file must not be written there; then nothing else counts

  std::string name() const { return file.filename().string(); }
  std::string folder() const { return file.has_parent_path() ? file.parent_path().string() : "."; }
};

Target find_target_within(const std::string& name, const std::string& within) {
  Target target;
  target.file = real_path(name);
  if (target.file.empty()) return target.error = errno, target;
  if (!is_within(target.file, within)) return target.outside = outside_text(target.file), target;
  struct stat now = {};
  if (::lstat(target.file.c_str(), &now) == 0)
    target.now = now;
  else
    target.error = errno == ENOENT ? 0 : errno;
  return target;
}

Target find_target(const std::string& name, const std::string& within) {
  if (!within.empty()) return find_target_within(name, within);
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

/// Opens the target's folder; later calls go by its number, so a change of its name does not redirect them. `judged`:
/// the target's path is real, and is followed through no link.
int open_folder(const Target& target, bool judged) {
  constexpr int kFlags = O_PATH | O_DIRECTORY | O_CLOEXEC;
  return judged ? open_real(target.folder(), kFlags) : ::open(target.folder().c_str(), kFlags);
}

/// Nothing if the kind of file and its mode can be written to. A file without write permission for anybody is kept from
/// root, too.
std::string kind_fault(const struct stat& now, int folder, const std::string& name) {
  if (S_ISDIR(now.st_mode)) return "a folder has this name; choose another name";
  if (S_ISBLK(now.st_mode) || S_ISSOCK(now.st_mode))
    return "it is neither a regular file, a FIFO nor a character device; choose another name";
  if ((now.st_mode & 0222) == 0 || ::faccessat(folder, name.c_str(), W_OK, 0) != 0)
    return "the file is read-only; change its permissions or choose another name";
  return {};
}

/// A file without a name in the folder; -1 where the file system has none.
int open_unnamed(int folder) {
  return ::openat(folder, ".", O_WRONLY | O_TMPFILE | O_CLOEXEC, 0666);
}

std::string temporary_name() {
  static std::atomic<uint64_t> counter{0};
  return std::string(kTemporaryPrefix) + std::to_string(::getpid()) + "-" + std::to_string(counter++) +
         std::string(kTemporarySuffix);
}

/// A locked file under a temporary name. The lock vanishes with its process, which tells others that the file is stale.
int open_named(int folder, std::string& name) {
  for (int attempt = 0; attempt < 100; ++attempt) {
    name = temporary_name();
    const int handle = ::openat(folder, name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
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
void clear_stale(int folder) {
  const int number = ::openat(folder, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (number < 0) return;
  const std::unique_ptr<DIR, int (*)(DIR*)> list(::fdopendir(number), ::closedir);
  if (!list) {
    ::close(number);
    return;
  }
  while (const dirent* entry = ::readdir(list.get())) {
    const std::string_view name = entry->d_name;
    if (!name.starts_with(kTemporaryPrefix) || !name.ends_with(kTemporarySuffix)) continue;
    const Handle handle(::openat(folder, entry->d_name, O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
    if (handle && ::flock(handle.get(), LOCK_EX | LOCK_NB) == 0) ::unlinkat(folder, entry->d_name, 0);
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
std::string write_into(const Target& target, bool judged, const Writer& write) {
  constexpr int kFlags = O_WRONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC;
  Handle handle(judged ? open_real(target.file, kFlags) : ::open(target.file.c_str(), kFlags));
  if (!handle) return errno == ENXIO ? "nothing reads from this FIFO" : reason_of(errno);
  struct stat now = {};
  if (::fstat(handle.get(), &now) != 0 || ::fcntl(handle.get(), F_SETFL, 0) != 0) return reason_of(errno);
  if (!S_ISFIFO(now.st_mode) && !S_ISCHR(now.st_mode)) return "another file has taken its place; write again";
  int error = write(handle.get());
  if (const int closed = handle.close(); error == 0) error = closed;
  return error == 0 ? std::string() : reason_of(error);
}

/// Gives the written file its name, which replaces a file of this name at once. `temporary` is its name so far; empty:
/// it has none.
int put_in_place(int handle, std::string temporary, int folder, const std::string& name) {
  if (temporary.empty()) {
    const std::string self = "/proc/self/fd/" + std::to_string(handle);
    if (::linkat(AT_FDCWD, self.c_str(), folder, name.c_str(), AT_SYMLINK_FOLLOW) == 0) return 0;
    if (errno != EEXIST) return errno;
    static_cast<void>(::flock(handle, LOCK_EX | LOCK_NB));
    temporary = temporary_name();
    if (::linkat(AT_FDCWD, self.c_str(), folder, temporary.c_str(), AT_SYMLINK_FOLLOW) != 0) return errno;
  }
  if (::renameat(folder, temporary.c_str(), folder, name.c_str()) == 0) return 0;
  const int error = errno;
  ::unlinkat(folder, temporary.c_str(), 0);
  return error;
}

/// The rename must reach the disk too. Some network file systems cannot sync a folder: that is no failure.
void sync_folder(int folder) {
  const Handle handle(::openat(folder, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (handle) static_cast<void>(::fsync(handle.get()));
}

/// A target and its new content.
struct Replacement {
  const Target& target;
  const Writer& write;
  Flush flush = Flush::disk;
  int folder = -1;  // the target's, open
};

/// Writes a regular file by way of a new one. Returns errno, 0 if it went well.
int write_new(const Replacement& file, bool named) {
  const std::optional<struct stat>& old = file.target.now;
  std::string temporary;
  const int number = named ? open_named(file.folder, temporary) : open_unnamed(file.folder);
  if (number < 0) return errno;
  const Handle handle(number);
  int error = 0;
  if (old) {
    static_cast<void>(::fchown(number, old->st_uid, old->st_gid));  // where we may
    if (::fchmod(number, old->st_mode & 07777) != 0) error = errno;
  }
  if (error == 0) error = file.write(number);
  if (error == 0 && file.flush == Flush::disk && ::fsync(number) != 0) error = errno;
  if (error == 0) return put_in_place(number, temporary, file.folder, file.target.name());
  if (!temporary.empty()) ::unlinkat(file.folder, temporary.c_str(), 0);
  return error;
}

int replace_file(const Replacement& file) {
  clear_stale(file.folder);
  // Some systems make files without a name but let nobody name them.
  if (::access("/proc/self/fd", X_OK) == 0) {
    const int error = write_new(file, false);
    if (error == 0 || error == ECANCELED) return error;
  }
  return write_new(file, true);
}

std::string write_file(const Target& target, bool judged, const Writer& write, Flush flush) {
  if (!target.outside.empty()) return target.outside;
  // A file that the program's own output goes to (/dev/stdout) is not pulled away from under it.
  for (const int stream : {STDOUT_FILENO, STDERR_FILENO}) {
    struct stat own = {};
    if (!target.now || ::fstat(stream, &own) != 0) continue;
    if (own.st_dev != target.now->st_dev || own.st_ino != target.now->st_ino || !S_ISREG(own.st_mode)) continue;
    const int error = write(stream);
    return error == 0 ? std::string() : reason_of(error);
  }
  if (target.error != 0) return reason_of(target.error);
  const Handle folder(open_folder(target, judged));
  if (!folder) return reason_of(errno);
  if (target.now) {
    const std::string fault = kind_fault(*target.now, folder.get(), target.name());
    if (!fault.empty()) return fault;
    if (!S_ISREG(target.now->st_mode)) return write_into(target, judged, write);
  }
  const int error = replace_file({target, write, flush, folder.get()});
  if (error != 0) return reason_of(error);
  if (flush == Flush::disk) sync_folder(folder.get());
  return {};
}

}  // namespace

std::string OutputFault(const std::string& file, const std::string& within) {
  if (file.empty()) return "the name is empty; give the file a name";
  const Target target = find_target(file, within);
  if (!target.outside.empty()) return target.outside;
  const Handle folder(open_folder(target, !within.empty()));
  if (!folder) return folder_fault(target.folder(), errno);
  const long longest = ::fpathconf(folder.get(), _PC_NAME_MAX);
  if (longest > 0 && target.name().size() > size_t(longest))
    return "the name is longer than " + std::to_string(longest) + " bytes; shorten it";
  if (target.error != 0) return reason_of(target.error) + "; " + remedy_of(target.error);
  if (target.now) {
    const std::string fault = kind_fault(*target.now, folder.get(), target.name());
    if (!fault.empty() || !S_ISREG(target.now->st_mode)) return fault;
  }
  std::string temporary;
  int number = open_unnamed(folder.get());
  if (number < 0) number = open_named(folder.get(), temporary);
  if (number < 0) {
    const int error = errno;
    return "the folder '" + target.folder() + "' cannot be written to (" + reason_of(error) + "); " + remedy_of(error);
  }
  ::close(number);
  if (!temporary.empty()) ::unlinkat(folder.get(), temporary.c_str(), 0);
  return {};
}

std::string WriteOutputFile(const std::string& file, std::span<const uint8_t> bytes, Flush flush,
                            const std::string& within) {
  const auto writer = [bytes](int handle) { return write_all(handle, bytes); };
  return write_file(find_target(file, within), !within.empty(), writer, flush);
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
  return write_file(find_target(file, {}), false, writer, flush);
}

}  // namespace alabaster::hd::support
