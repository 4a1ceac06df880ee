// Names in a shell's commands and on terminals.
#pragma once

#include <string>

namespace alabaster::cli {

/// `word` as a POSIX shell reads it as one word: in single quotes if it would split or expand it.
std::string shell_word(const std::string& word);

/// The same of a file's name, which no command takes for an option.
std::string shell_path(const std::string& name);

/// Control characters of ASCII, and those of Unicode in UTF-8: they end a line, or change what a terminal shows.
bool has_control_character(const std::string& text);

/// `text` with its control characters written as \x0a, but for those of `kept`.
std::string without_control_characters(const std::string& text, const std::string& kept = "");

}  // namespace alabaster::cli
