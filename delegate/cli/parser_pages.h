// The man page and the completion scripts of shells, made from the parser of the command line.
#pragma once

#include <string>

namespace CLI {
class App;
}  // namespace CLI

namespace alabaster::cli {

// Both print to standard output and return an exit code.
/// A page of section 1 in roff, with a section for each command of `app`.
int run_man(const CLI::App& app);
/// A script for `shell`, which is bash, zsh or fish: it completes commands, flags and files.
int run_completion(const CLI::App& app, const std::string& shell);

}  // namespace alabaster::cli
