// Files that could not be read, kept so that a damaged one is read once, however many prims name it.
#pragma once

#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/texture/texture.h"
#include "delegate/prims/records.h"

namespace alabaster::hd::prims {

/// The time and size of a file, or of each file of a set of images. They change when it is written.
using FileState = std::vector<std::pair<std::filesystem::file_time_type, uintmax_t>>;
FileState state_of(const TextureSource& source);

/// Any thread.
class FailedFiles {
 public:
  struct Failure {
    std::string fault;
    std::vector<alabaster::Diagnostic> reports;  // for every prim that names the file
  };
  /// `state`: as it was before the file was read. A colour space that is not known does not count as a failure.
  void keep(const TextureSource& source, FileState state, Failure failure);
  /// None if the file has been written since.
  std::optional<Failure> find(const TextureSource& source) const;
  /// Forgets images that names_image() matches with `file`.
  void forget(const std::string& file);

 private:
  struct Kept {
    std::weak_ptr<const std::vector<uint8_t>> bytes;  // of an image that is in memory
    bool is_in_memory = false;
    std::string within;
    FileState state;
    Failure failure;
  };
  mutable std::mutex mutex_;
  std::multimap<std::string, Kept> kept_;  // by path
};

}  // namespace alabaster::hd::prims
