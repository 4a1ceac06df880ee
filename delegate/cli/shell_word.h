// Words of a command that a person may copy into a shell.
#pragma once

#include <string>

namespace alabaster::cli {

/// `word` as a POSIX shell reads it as one word: in single quotes if it would split or expand it.
std::string shell_word(const std::string& word);

}  // namespace alabaster::cli
