// A study on disk: every picture rendered so far with its cost, so that an interrupted study can be resumed.
//
// FOLDER/state.json lists the pictures with their checksums. Each is a file beside it, with rows of 32-bit floats in
// the machine's byte order. All files are written under temporary names and renamed.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "delegate/tradeoff/configurations.h"
#include "delegate/tradeoff/image.h"
#include "delegate/tradeoff/plan.h"

namespace alabaster::tradeoff {

/// The limit of setting `samples`.
inline constexpr uint64_t kMostSamples = uint64_t(1) << 20;

/// Pictures can be compared only if all of this is the same.
struct StudyIdentity {
  std::string scene;       // as given
  std::string scene_hash;  // of the scene's content
  int width = 0, height = 0;
  std::string versions;  // AlabasterVersions(); empty in studies that did not record it
  bool operator==(const StudyIdentity&) const = default;
};

/// The cost of a picture and its own estimate of its error.
struct RenderCost {
  double cpu_seconds = 0, wall_seconds = 0;                  // of rendering; CPU of all threads together
  double total_seconds = 0;                                  // wall time with all overheads
  double reported_error = -1;                                // relative RMSE that the render reported; < 0 if none
  double denoise_cpu_seconds = 0, denoise_wall_seconds = 0;  // of denoising, on top
};

struct StoredRender {
  std::string configuration, fingerprint;
  uint64_t samples = 0;
  int replica = 0;
  RenderCost cost;
  std::string file, checksum;
  std::string denoised_file = {}, denoised_checksum = {};  // empty: it was not denoised
};

/// FNV-1a over the bytes, 16 hexadecimal digits. Detects damage and change, not malice.
std::string checksum(const void* bytes, size_t size);

class StudyStore {
 public:
  /// Opens `folder`, or makes it. A damaged or foreign state.json is an error. A missing or damaged picture is dropped
  /// together with its time, and noted. With `restart` everything in the folder is removed first. Empty on success,
  /// else the problem and its remedy.
  std::string open(const std::filesystem::path& folder, bool restart);
  bool empty() const { return renders_.empty(); }
  const std::vector<std::string>& notes() const { return notes_; }

  StudyIdentity identity;
  uint64_t reference_samples = 0;
  double spent = 0;  // seconds, of all runs

  const std::vector<StoredRender>& renders() const { return renders_; }
  /// Writes the picture, and the denoised one unless it is empty, then the list. Empty on success, else the reason; the
  /// list is then unchanged.
  std::string add(StoredRender render, const Image& image, const Image& denoised = {});
  /// None if the file can no longer be read or has changed.
  std::optional<Image> read(const StoredRender& render) const { return read(render.file, render.checksum); }
  std::optional<Image> read_denoised(const StoredRender& render) const {
    return read(render.denoised_file, render.denoised_checksum);
  }

 private:
  std::string clear();
  std::string save() const;
  std::optional<Image> read(const std::string& name, const std::string& expected_checksum) const;
  bool parse(const std::string& text);

  std::filesystem::path folder_;
  std::vector<StoredRender> renders_;
  std::vector<std::string> notes_;
};

}  // namespace alabaster::tradeoff
