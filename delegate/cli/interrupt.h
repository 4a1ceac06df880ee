// Ctrl-C and SIGTERM. While there is nothing to save the first one ends the program at once; later it asks the render
// to stop and write what there is, and a second one ends the program without waiting. Once files are being written the
// program ends by itself, and cut short it would leave temporary files behind: then signals no longer end it (SIGQUIT,
// Ctrl-backslash in a terminal, still does). Files are renamed into place only when whole, so none is left broken.
#pragma once

#include <atomic>

namespace alabaster::cli {

/// From here on signals are ours.
void catch_interrupts();
/// Whether a picture exists that an interrupted run should still write.
void set_worth_saving(bool worth_saving);
/// Whether files are being written.
void set_writing(bool writing);
/// Set by a signal while something is worth saving.
const std::atomic<bool>& interrupted();

}  // namespace alabaster::cli
