// Draws with the program gnuplot (Debian: gnuplot-nox), run without a shell.
#pragma once

#include <functional>
#include <string>

namespace alabaster::tradeoff {

/// `text` as a gnuplot string literal in which nothing is substituted or run; control characters become spaces.
std::string gnuplot_quoted(const std::string& text);

/// Empty if $PATH has the program, else the remedy.
std::string gnuplot_fault();

/// Runs the script that `script` returns for a path to draw into, then renames the drawing to `file`, so that `file` is
/// replaced whole or not at all. Empty on success, else the problem and its remedy.
std::string draw_with_gnuplot(const std::function<std::string(const std::string&)>& script, const std::string& file);

}  // namespace alabaster::tradeoff
