// Names of files that an untrusted file gives lead to files in a folder or below. A name is judged by its real path:
// absolute, with symbolic links followed, and without "." or "..".
#pragma once

#include <string>

namespace alabaster {

/// The real path of a name; its last parts need not exist. Empty, with errno as the reason, where links cannot be
/// followed. An empty name is the working folder.
std::string real_path(const std::string& name);

/// The real path of a folder that files are allowed in. Where it has none, a text that no file lies in.
std::string allowed_folder(const std::string& folder);

/// True if the real path is `folder`, another real path, or lies below it.
bool is_within(const std::string& real, const std::string& folder);

/// Nothing if `file` lies in `folder`, a real path, or below; else the reason with its remedy. The file need not exist.
/// This is for a message in time: opening and writing judge again.
std::string outside_fault(const std::string& folder, const std::string& file);
std::string outside_text(const std::string& real);

/// open(2) for a real path. No link is followed on the way: where a part of the path has become one meanwhile, this
/// fails with ELOOP, so the file that is opened is the one that was judged. Kernels without openat2, and sandboxes that
/// refuse it, need /proc.
int open_real(const std::string& real, int flags);

}  // namespace alabaster
