// Control characters in names: they end a line, or change what a terminal shows.
#pragma once

#include <string>

namespace alabaster::cli {

/// Those of ASCII, and those of Unicode in UTF-8.
bool has_control_character(const std::string& text);

/// `text` with its control characters written as \x0a, but for those of `kept`.
std::string without_control_characters(const std::string& text, const std::string& kept = "");

}  // namespace alabaster::cli
