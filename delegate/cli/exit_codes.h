// The program's exit codes.
#pragma once

#include "delegate/host/frame_recorder.h"

namespace alabaster::cli {

/// kDegraded: with --keep-going, rendered and written without what the scene's faults left out.
enum ExitCode { kDone = 0, kUsage = 2, kInput = 3, kRender = 4, kOutput = 5, kDegraded = 6, kInterrupted = 130 };

inline int exit_code(hd::host::RecordStatus status) {
  using hd::host::RecordStatus;
  switch (status) {
    case RecordStatus::done:
      return kDone;
    case RecordStatus::input_failed:
      return kInput;
    case RecordStatus::render_failed:
      return kRender;
    case RecordStatus::output_failed:
      return kOutput;
    case RecordStatus::interrupted:
      return kInterrupted;
    case RecordStatus::degraded:
      return kDegraded;
  }
  return kRender;
}

}  // namespace alabaster::cli
