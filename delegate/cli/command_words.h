// Corrections of command lines: wrong words, the nearest right ones, and commands that work.
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
class ParseError;
}  // namespace CLI

namespace alabaster::cli {

/// Words of a command line. `words` of the functions below begin with the name of a command.
using Words = std::vector<std::string>;

/// A word of other programs, and ours. `value`: in the place of one that is a plain number, which % stands for; null:
/// it stays.
struct Alias {
  const char *word, *ours, *value;
};
inline constexpr Alias kCommandAliases[] = {
    {"open", "view", nullptr},   {"show", "view", nullptr},      {"gui", "view", nullptr},
    {"list", "info", nullptr},   {"inspect", "info", nullptr},   {"validate", "check", nullptr},
    {"submit", "farm", nullptr}, {"export", "convert", nullptr}, {"benchmark", "tradeoff", nullptr}};
inline constexpr Alias kFlagAliases[] = {{"sample", "--spp", nullptr},
                                         {"num-samples", "--spp", nullptr},
                                         {"samples-per-pixel", "--spp", nullptr},
                                         {"width", "--size", "1280x720"},
                                         {"height", "--size", "1280x720"},
                                         {"res", "--size", "1280x720"},
                                         {"resolution", "--size", "1280x720"},
                                         {"out", "--output", nullptr},
                                         {"noise", "--target-error", nullptr},
                                         {"noise-threshold", "--target-error", nullptr},
                                         {"env", "--dome", nullptr},
                                         {"envmap", "--dome", nullptr},
                                         {"environment", "--dome", nullptr},
                                         {"hdri", "--dome", nullptr},
                                         {"sky", "--dome", nullptr},
                                         {"bounces", "--max-depth", nullptr},
                                         {"depth", "--max-depth", nullptr},
                                         {"cores", "--threads", nullptr},
                                         {"jobs", "--threads", nullptr},
                                         {"preset", "--quality", nullptr},
                                         {"layer", "--aov", nullptr},
                                         {"frame", "--frames", "%:%"}};

/// Five examples and the places of the help, which the program shows without arguments.
std::string examples_text();

/// Describes the fault `error` of a command line that `app` refused: the wrong word, the nearest right one, and a
/// command that works. Empty if no word is wrong by itself.
std::string word_fault(const CLI::App& app, const Words& words, const CLI::ParseError& error);

/// The same of the words of one command, "view" and its options, that `command` refused.
std::string command_fault(const CLI::App& command, const Words& words, const CLI::ParseError& error);

/// The command with each unknown choice of a flag replaced by the nearest one. Empty if all choices are known, or if
/// one of them has no near one.
std::string with_near_choices(const CLI::App& app, const Words& words);

/// "--output", also of an option that the help does not list; empty for SCENE and the like.
std::string option_name(const CLI::Option& option);

/// The engines of command farm.
const Words& farm_engines();

/// "slurm, openjd, script"
std::string joined(const Words& names, const std::string& between = ", ");

/// `words` without the options `left_out`, each of which has a value, and with `added`.
Words with_options(const Words& words, const Words& left_out, const Words& added);

/// "alabaster WORDS" as a shell reads it. Empty if a word holds control characters, which cannot be copied from a
/// terminal.
std::string command_text(const Words& words);

}  // namespace alabaster::cli
