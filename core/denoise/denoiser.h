// Open Image Denoise 2 (www.openimagedenoise.org), found at run time: nothing is linked to it, and a machine without it
// lacks only this.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace alabaster {

/// A picture and the guides that say where its edges are. Rows of pixels, three floats each.
struct DenoiserFrame {
  size_t width = 0, height = 0;
  std::vector<float> color;   // linear, 0 or more, of any range
  std::vector<float> albedo;  // 0 to 1
  std::vector<float> normal;  // -1 to 1, zero where nothing was hit; need not be unit
};

enum class DenoiseStatus { done, cancelled, failed };

struct DenoiseOptions {
  uint32_t threads = 0;  // 0: all
  /// Called with the share of the work that is done, 0 to 1, by any thread but by one at a time. False cancels. Must
  /// not throw. Null: not called.
  std::function<bool(double fraction)> progress;
};

class Denoiser {
 public:
  /// Finds and loads the library, which takes milliseconds. Null, with the reason and the remedy in *problem, if it is
  /// missing, older than version 2, lacks a function or refuses this processor. It is looked for
  /// - where $ALABASTER_OIDN says, a file or a folder, and then nowhere else;
  /// - in the folder `oidn` beside this program or library, or beside the folder that it lies in;
  /// - where the system finds libraries;
  /// - in the folders of Python packages: the wheel `pyoidn` carries it.
  /// A folder may hold the library itself, in `lib`, or in a Python package `pyoidn`.
  static std::shared_ptr<const Denoiser> load(std::string* problem);
  ~Denoiser();
  Denoiser(const Denoiser&) = delete;
  Denoiser& operator=(const Denoiser&) = delete;

  /// "Open Image Denoise 2.5.1"
  const std::string& name() const { return name_; }
  /// The library's file, as it was loaded.
  const std::string& file() const { return file_; }

  /// Replaces the frame's color by the denoised one. The guides are denoised first, in place, as the library's manual
  /// recommends. Runs on the CPU, in the calling thread and in threads of TBB, with the same bytes for any number of
  /// them. If it is cancelled or fails (*problem says why), the frame's contents are unspecified. Any thread.
  DenoiseStatus denoise(DenoiserFrame* frame, const DenoiseOptions& options, std::string* problem) const;

 private:
  struct Functions;
  Denoiser(std::string file, std::unique_ptr<const Functions> functions, int version);
  static std::shared_ptr<const Denoiser> open(const std::string& file, std::string* problem);

  std::string file_, name_;
  std::unique_ptr<const Functions> functions_;
};

}  // namespace alabaster
