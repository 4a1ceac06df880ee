// Files that are read. Only regular files are: a FIFO or a device may have no end.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace alabaster {

/// Why a part of a path, or the beginning of one, is of no file of this system, with the remedy: it is a URI with a
/// scheme, has a drive letter, or has backslashes. Else empty.
std::string foreign_name(std::string_view part);

/// An open file. It is judged after it is opened, and stays the same file when its name changes.
class InputFile {
 public:
  /// foreign: there is no such file, since its name is no path of this system.
  enum class Fault { none, missing, foreign, not_regular, outside, unreadable };

  /// `within`: a real path (core/files/real_path.h) of a folder that the file must lie in or below; empty: anywhere.
  explicit InputFile(const std::string& path, const std::string& within = {});
  ~InputFile();
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  explicit operator bool() const { return fault_ == Fault::none; }
  Fault fault() const { return fault_; }
  /// Why it is not read, with the remedy.
  const std::string& reason() const { return reason_; }
  /// As it was when the file was opened.
  uint64_t size() const { return size_; }
  int descriptor() const { return descriptor_; }
  /// False if the file ends before, or cannot be read. Any thread.
  bool read(uint64_t offset, void* out, size_t count) const;
  /// All of it, into a std::string or a std::vector<uint8_t>.
  template <class Contents>
  bool read(Contents* contents) const {
    contents->resize(size_);
    return read(0, contents->data(), contents->size());
  }

 private:
  bool fail(Fault fault, const std::string& reason);
  bool fail(int error, const std::string& path);
  bool open(const std::string& path, const std::string& within);

  Fault fault_ = Fault::none;
  std::string reason_;
  uint64_t size_ = 0;
  int descriptor_ = -1;
};

}  // namespace alabaster
