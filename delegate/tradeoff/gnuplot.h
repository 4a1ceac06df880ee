// Drawing with the program gnuplot (Debian: gnuplot-nox), run without a shell.
#pragma once

#include <functional>
#include <string>

namespace alabaster::tradeoff {

/// `text` as gnuplot takes it literally, with nothing in it that is replaced or run; control characters are spaces.
std::string gnuplot_quoted(const std::string& text);

/// Runs the script that `script` returns for the path that it is to draw into, and puts what was drawn in the place of
/// `file`, whole or not at all. Empty on success, else what is wrong and what to do about it.
std::string draw_with_gnuplot(const std::function<std::string(const std::string&)>& script, const std::string& file);

}  // namespace alabaster::tradeoff
