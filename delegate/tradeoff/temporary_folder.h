// A folder for files that nobody is to keep.
#pragma once

#include <filesystem>
#include <string>

namespace alabaster::tradeoff {

/// A new folder under $TMPDIR (else /tmp) that only this user may enter, gone with all that is in it when this object
/// goes. A process that a signal ends destroys no objects: who has one catches signals. Throws nothing but bad_alloc.
class TemporaryFolder {
 public:
  /// Its name is `prefix` and six further characters.
  explicit TemporaryFolder(const std::string& prefix);
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  /// Empty: it could not be made.
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace alabaster::tradeoff
