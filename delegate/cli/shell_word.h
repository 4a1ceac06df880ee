// Words of a command that a shell reads.
#pragma once

#include <string>

namespace alabaster::cli {

/// `word` as a POSIX shell reads it as one word: in single quotes if it would split or expand it.
std::string shell_word(const std::string& word);

/// The same of a file's name, which no command takes for an option.
std::string shell_path(const std::string& name);

}  // namespace alabaster::cli
