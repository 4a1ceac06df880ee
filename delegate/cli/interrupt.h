// Ctrl-C and SIGTERM. While there is nothing to save, the first signal ends the program at once. Later the first one
// asks the render to stop and write the picture so far, and a second one ends the program without waiting. While files
// are being written, signals are ignored, because ending then would leave temporary files behind (SIGQUIT,
// Ctrl-backslash in a terminal, still ends the program). Files are renamed into place only when complete, so none is
// left broken.
#pragma once

#include <atomic>

namespace alabaster::cli {

/// Installs the signal handlers.
void catch_interrupts();
/// Says if there is a picture that an interrupted run should still write.
void set_worth_saving(bool worth_saving);
/// Says if files are being written.
void set_writing(bool writing);
/// Set by a signal while something is worth saving.
const std::atomic<bool>& interrupted();

}  // namespace alabaster::cli
