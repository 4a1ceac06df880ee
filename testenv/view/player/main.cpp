// alabaster-view-player SCRIPT [options of alabaster view] SCENE: the window, with the lines of a file in the place of
// the user.
#include <cstdio>

#include "core/files/input_file.h"
#include "delegate/cli/exit_codes.h"
#include "testenv/view/player/script_player.h"

namespace {

// The file's text. The reason why there is none, or empty.
std::string read(const char* file, std::string* text) {
  const alabaster::InputFile input(file);
  if (!input) return "it cannot be read: " + input.reason();
  return input.read(text) && !text->empty() ? "" : "it could not be read to its end, or is empty";
}

}  // namespace

int main(int argc, char** argv) {
  using namespace alabaster;
  const char* const file = argc > 1 ? argv[1] : "SCRIPT";
  std::string text, problem = argc > 1 ? read(file, &text) : "the first argument names a script";
  view::Script script;
  if (problem.empty()) script = view::read_script(text), problem = script.problem;
  if (!problem.empty()) {
    std::fprintf(stderr, "error: %s: %s\n", file, problem.c_str());
    return cli::kUsage;
  }
  view::ScriptPlayer player(std::move(script));
  return view::run_program(argc - 1, argv + 1, &player);
}
