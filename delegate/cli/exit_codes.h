// The program's exit codes.
#pragma once

namespace alabaster::cli {

enum ExitCode { kDone = 0, kUsage = 2, kInput = 3, kRender = 4, kOutput = 5, kInterrupted = 130 };

}  // namespace alabaster::cli
