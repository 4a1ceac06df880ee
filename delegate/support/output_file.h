// Files that a run writes. A regular file is there whole or as it was before, and keeps its mode; a name that is a
// symbolic link stays one. FIFOs and character devices are written into. Nothing else is touched.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>

namespace alabaster::hd::support {

/// disk: the call returns when the bytes are on the disk, where they outlive a loss of power.
enum class Flush { disk, none };

/// Checks, before there is anything to write, that `file` can be written: its folder, its name, its permissions and its
/// kind. Returns nothing if so, else the reason with its remedy. The file is left as it is. `within`: a real path
/// (core/files/real_path.h) of a folder that the file must lie in or below, links followed; empty: anywhere.
std::string OutputFault(const std::string& file, const std::string& within = {});

/// Writes `bytes` to a file that nobody sees before it is complete. Returns nothing on success, else the reason; a
/// regular file is then as it was before, or, where its folder cannot be flushed, new. The bytes go to a file
/// `.alabaster-HOST-PROCESS-NUMBER.tmp` beside it, which is renamed; only a process that is killed leaves that behind.
/// Owner, mode and flush are left out where the file system refuses them. `within`: as in OutputFault; it is judged as
/// the folder is opened that the file is then written in. Any thread.
std::string WriteOutputFile(const std::string& file, std::span<const uint8_t> bytes, Flush flush = Flush::disk,
                            const std::string& within = {});

/// Writes `bytes`, which `file` did not take, to a file of the same name in a new folder of the system's temporary one.
/// Returns the path, or nothing where that fails too. Any thread.
std::string KeepElsewhere(const std::string& file, std::span<const uint8_t> bytes);

/// Takes the next bytes of a file; false: they cannot be written.
using ByteSink = std::function<bool(std::span<const uint8_t>)>;
/// The same for a file too large to be in memory as a whole. `write` gives its bytes to the sink, in order, and returns
/// false to give up.
std::string StreamOutputFile(const std::string& file, const std::function<bool(const ByteSink&)>& write,
                             Flush flush = Flush::disk);

}  // namespace alabaster::hd::support
