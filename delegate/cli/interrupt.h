// Signals that end the program: Ctrl-C, SIGTERM, SIGHUP (the terminal has gone), SIGPIPE (nobody reads the messages any
// more), SIGXCPU and SIGXFSZ (a limit of the shell). While there is nothing to save, the first signal ends the program
// at once. Later the first one asks the render to stop and write the picture so far, and a second one ends the program
// without waiting; the last three kinds repeat themselves, so only their first one counts. While files are being
// written, signals are ignored, because ending then would lose them (SIGQUIT, Ctrl-backslash in a terminal, still ends
// the program). Files are renamed into place only when complete, so none is left broken.
#pragma once

#include <sys/types.h>

#include <atomic>

namespace alabaster::cli {

/// Installs the signal handlers. A signal that the parent ignores stays ignored (nohup, background jobs of a script).
void catch_interrupts();
/// Says if there is a picture that an interrupted run should still write.
void set_worth_saving(bool worth_saving);
/// Says if files are being written.
void set_writing(bool writing);
/// A signal that ends the program at once writes a 1 into that place of an open file first. -1: none.
void set_told_of_end(int descriptor, off_t place);
/// Set by a signal while something is worth saving.
const std::atomic<bool>& interrupted();

}  // namespace alabaster::cli
