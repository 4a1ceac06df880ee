#include "delegate/support/output_file.h"

#include <fcntl.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <filesystem>
#include <optional>
#include <system_error>

#include "core/files/real_path.h"
#include "core/files/temporary_folder.h"

namespace alabaster::hd::support {
namespace {

namespace fs = std::filesystem;

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

/// Errors of a flush that a file system does not have. Then the file counts as flushed.
bool is_without_flush(int error) {
  return error == EINVAL || error == ENOTSUP || error == EPERM || error == ENOSYS;
}

/// errno, 0 if it went well.
int flush_file(int handle) {
  while (::fsync(handle) != 0)
    if (errno != EINTR) return is_without_flush(errno) ? 0 : errno;
  return 0;
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
    if (::close(number) == 0 || errno == EINTR || is_without_flush(errno)) return 0;
    return errno;
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

/// `within`: as of OutputFault.
Target find_target(const std::string& name, const std::string& within) {
  Target target;
  target.file = name;
  struct stat now = {};
  if (within.empty() && ::stat(name.c_str(), &now) == 0 && !S_ISREG(now.st_mode)) {
    target.now = now;  // what lies behind /dev/stdout need not have a path
    return target;
  }
  const std::string real = real_path(name);
  if (real.empty()) return target.error = errno, target;
  target.file = real;
  if (!within.empty() && !is_within(real, within)) return target.outside = outside_text(real), target;
  if (::lstat(real.c_str(), &now) == 0)
    target.now = now;
  else
    target.error = errno == ENOENT ? 0 : errno;
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

/// No other process, on this machine or another, has a file of this name.
std::string temporary_name() {
  char host[HOST_NAME_MAX + 1] = {};
  static_cast<void>(::gethostname(host, HOST_NAME_MAX));
  uint64_t number = 0;
  static_cast<void>(::getrandom(&number, sizeof number, 0));
  std::string name =
      ".alabaster-" + std::string(host) + "-" + std::to_string(::getpid()) + "-" + std::to_string(number) + ".tmp";
  std::replace(name.begin(), name.end(), '/', '_');
  return name;
}

/// A new file beside the target, which is removed at the end unless it was renamed.
class Temporary {
 public:
  Temporary(int folder, mode_t mode) : folder_(folder), handle_(open(mode)), error_(handle_ ? 0 : errno) {}
  ~Temporary() {
    if (error_ == 0 && !name_.empty()) ::unlinkat(folder_, name_.c_str(), 0);
  }
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;
  /// errno of making it.
  int error() const { return error_; }
  int get() const { return handle_.get(); }
  /// Closes it and replaces the file `name`. Returns errno, 0 if it went well.
  int put_in_place(const std::string& name) {
    if (const int error = handle_.close(); error != 0) return error;
    if (::renameat(folder_, name_.c_str(), folder_, name.c_str()) != 0) return errno;
    name_.clear();
    return 0;
  }

 private:
  int open(mode_t mode) {
    for (int attempt = 0; attempt < 100; ++attempt) {
      name_ = temporary_name();
      const int number = ::openat(folder_, name_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
      if (number >= 0 || errno != EEXIST) return number;
    }
    return -1;
  }

  int folder_;
  std::string name_;
  Handle handle_;
  int error_;
};

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

/// A target and its new content.
struct Replacement {
  const Target& target;
  const Writer& write;
  Flush flush = Flush::disk;
  int folder = -1;  // the target's, open
};

/// Writes a regular file by way of a new one. Returns errno, 0 if it went well.
int replace_file(const Replacement& file) {
  const std::optional<struct stat>& old = file.target.now;
  Temporary written(file.folder, old ? old->st_mode & 0777 : 0666);
  if (written.error() != 0) return written.error();
  if (old) {  // where the file system permits it
    static_cast<void>(::fchown(written.get(), old->st_uid, old->st_gid));
    static_cast<void>(::fchmod(written.get(), old->st_mode & 07777));
  }
  if (const int error = file.write(written.get()); error != 0) return error;
  if (file.flush == Flush::none) return written.put_in_place(file.target.name());
  if (const int error = flush_file(written.get()); error != 0) return error;
  if (const int error = written.put_in_place(file.target.name()); error != 0) return error;
  const Handle folder(::openat(file.folder, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  return folder ? flush_file(folder.get()) : 0;  // a folder may be written to and not read
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
  return error == 0 ? std::string() : reason_of(error);
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
  if (const int error = Temporary(folder.get(), 0666).error(); error != 0)
    return "the folder '" + target.folder() + "' cannot be written to (" + reason_of(error) + "); " + remedy_of(error);
  return {};
}

std::string WriteOutputFile(const std::string& file, std::span<const uint8_t> bytes, Flush flush,
                            const std::string& within) {
  const auto writer = [bytes](int handle) { return write_all(handle, bytes); };
  return write_file(find_target(file, within), !within.empty(), writer, flush);
}

std::string KeepElsewhere(const std::string& file, std::span<const uint8_t> bytes) {
  std::string folder = temporary_folder() + "/alabaster_XXXXXX";
  if (!::mkdtemp(folder.data())) return {};
  const fs::path kept = fs::path(folder) / fs::path(file).filename();
  if (WriteOutputFile(kept.string(), bytes).empty()) return kept.string();
  std::error_code ignored;
  fs::remove(folder, ignored);
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
