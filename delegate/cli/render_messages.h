// The messages of command render while it renders and at its end.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "delegate/cli/commands.h"
#include "delegate/cli/stats_file.h"

namespace alabaster::cli {

/// Prints through a console: the size and the limits of a render, its progress with the noise so far, the time that it
/// will take, and at its end its noise, its files and the next command. One thread.
class RenderMessages {
 public:
  /// All outlive this object.
  RenderMessages(const RenderArguments& arguments, const SceneSession& session, Console* console);
  /// While `frame` is rendered.
  void progress(const hd::RenderSettingsDescription& frame, const hd::host::RecordProgress& progress);
  /// Frame `number` of --frames, the `done`th, is over. `seconds`: of a frame.
  void end_frame(double number, size_t done, double seconds, const std::vector<std::string>& written);
  /// A render of `frame` is over.
  void add(const hd::RenderSettingsDescription& frame, const hd::host::RecordResult& result);
  /// All frames are over, and rendered.
  void summarize(const RunStats& stats, bool degraded);

 private:
  double noise_so_far(double seconds);
  void begin(const hd::RenderSettingsDescription& frame, const hd::host::RecordProgress& progress);
  void estimate(const hd::RenderSettingsDescription& frame, const hd::host::RecordProgress& progress, double noise);
  std::string shorter(const hd::RenderSettingsDescription& frame) const;

  const RenderArguments& a_;
  const SceneSession& session_;
  Console& console_;
  bool begun_ = false, estimated_ = false, warned_ = false;
  double asked_ = 0;  // seconds of the frame when its noise was last requested
  double noise_ = -1;
  bool denoised_ = false;
  std::vector<std::pair<std::string, std::string>> written_;  // file and size
};

}  // namespace alabaster::cli
