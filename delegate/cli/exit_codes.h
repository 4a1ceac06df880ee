// The program's exit codes.
#pragma once

namespace alabaster::cli {

/// kDegraded: with --keep-going, rendered and written without what the scene's faults left out.
enum ExitCode { kDone = 0, kUsage = 2, kInput = 3, kRender = 4, kOutput = 5, kDegraded = 6, kInterrupted = 130 };

}  // namespace alabaster::cli
