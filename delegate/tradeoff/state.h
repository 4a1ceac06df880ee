// A study on disk: every picture rendered so far and what it cost, so that an interrupted study goes on.
//
// FOLDER/state.json lists the pictures; each is a file beside it: rows of 32-bit floats in the byte order of the
// machine, with its checksum in the list. All files are written under temporary names and renamed.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "delegate/tradeoff/configurations.h"
#include "delegate/tradeoff/image.h"
#include "delegate/tradeoff/plan.h"

namespace alabaster::tradeoff {

/// What pictures must share to be compared.
struct StudyIdentity {
  std::string scene;       // as given
  std::string scene_hash;  // of what the scene holds
  int width = 0, height = 0;
  std::string versions;  // AlabasterVersions(); empty: of a study from before they were noted
  bool operator==(const StudyIdentity&) const = default;
};

/// What a picture cost, and what it said about itself.
struct RenderCost {
  double cpu_seconds = 0, wall_seconds = 0;  // of rendering; CPU of all threads together
  double total_seconds = 0;                  // wall time with everything about it
  double reported_error = -1;                // relative RMSE that the render estimated in itself; < 0: none
};

struct StoredRender {
  std::string configuration, fingerprint;
  uint64_t samples = 0;
  int replica = 0;
  RenderCost cost;
  std::string file, checksum;
};

/// FNV-1a over the bytes, 16 hexadecimal digits. Recognizes damage and change, not malice.
std::string checksum(const void* bytes, size_t size);

class StudyStore {
 public:
  /// `folder` is made if it is not there. A damaged or foreign state.json is a problem; a picture that is missing or
  /// damaged is forgotten, its time too, and noted. With `restart` whatever was there is removed. Empty on success,
  /// else what is wrong and the remedy.
  std::string open(const std::filesystem::path& folder, bool restart);
  bool empty() const { return renders_.empty(); }
  const std::vector<std::string>& notes() const { return notes_; }

  StudyIdentity identity;
  uint64_t reference_samples = 0;
  double spent = 0;  // seconds, of all runs

  const std::vector<StoredRender>& renders() const { return renders_; }
  /// Writes the picture, then the list. Empty on success; else the reason, and the list is what it was.
  std::string add(StoredRender render, const Image& image);
  /// None if it can no longer be read, or is not what was written.
  std::optional<Image> read(const StoredRender& render) const;

 private:
  std::string clear();
  std::string save() const;
  bool parse(const std::string& text);

  std::filesystem::path folder_;
  std::vector<StoredRender> renders_;
  std::vector<std::string> notes_;
};

}  // namespace alabaster::tradeoff
