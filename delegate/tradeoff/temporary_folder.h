// A folder for temporary files.
#pragma once

#include <filesystem>
#include <string>

namespace alabaster::tradeoff {

/// A new folder under $TMPDIR (else /tmp) that only this user may enter. The destructor removes it with its contents. A
/// signal that ends the process runs no destructors, so the caller catches signals. Throws nothing but bad_alloc.
class TemporaryFolder {
 public:
  /// The folder's name is `prefix` and six further characters.
  explicit TemporaryFolder(const std::string& prefix);
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  /// Empty if the folder could not be made.
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace alabaster::tradeoff
