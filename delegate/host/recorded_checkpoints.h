// The checkpoints of a recording. Internal to the frame recorder.
#pragma once

#include <chrono>
#include <nlohmann/json.hpp>

#include "delegate/host/frame_recorder.h"

namespace alabaster::hd::host {

class RecordedCheckpoints {
 public:
  static constexpr const char* kCode = "record.checkpoint";  // of reports

  /// `delegate` and `options` must outlive it. Without RecordOptions::checkpoint nothing is written.
  RecordedCheckpoints(RenderDelegate* delegate, const RecordOptions& options, const Path& settings)
      : delegate_(delegate), options_(options), settings_(settings) {}

  /// Has the delegate go on from the file, if RecordOptions::resume asks for it. Else than done after a report.
  CommandResult resume();
  /// The render begins: the first checkpoint is due an interval later.
  void begin();
  /// A file that cannot be written now may be later: that is a warning, given once.
  void write_if_due(const RenderSettingsDescription& settings);
  void write_last(const RenderSettingsDescription& settings);
  /// Why write_last() failed; empty if it did not.
  const std::string& last_fault() const { return last_fault_; }
  /// Adds checkpoint.count and phase.checkpoint.wall, the seconds that they took.
  void add_to(Dictionary* stats) const;

 private:
  /// Why not; empty if it is written.
  std::string write(const RenderSettingsDescription& settings);
  std::string note(const RenderSettingsDescription& settings) const;
  void report(Severity severity, const std::string& text) const;

  RenderDelegate* delegate_;
  const RecordOptions& options_;
  Path settings_;
  nlohmann::json colors_;  // the configuration, for the note
  std::chrono::steady_clock::time_point saved_;
  int count_ = 0;
  double seconds_ = 0;
  bool warned_ = false;
  std::string last_fault_;
};

}  // namespace alabaster::hd::host
