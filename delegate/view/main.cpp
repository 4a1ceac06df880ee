// The program alabaster-view: a window on a scene. It uses the public contract and the kit, nothing else.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <sstream>

#include "core/files/input_file.h"
#include "delegate/cli/control_characters.h"
#include "delegate/cli/exit_codes.h"
#include "delegate/cli/scene_options.h"
#include "delegate/view/window.h"

namespace alabaster::view {
namespace {

struct Arguments {
  cli::SceneArguments scene;
  std::string script;
  bool quiet = false;
};

// Reads the script; an exit code.
int load_script(const std::string& file, Script* script, cli::Console* console) {
  if (file.empty()) return cli::kDone;
  const InputFile input(file);
  std::string text;
  if (!input) return console->usage_error(file, "The script cannot be read: " + input.reason() + ".");
  if (!input.read(&text) || text.empty())
    return console->usage_error(file, "The script could not be read to its end, or is empty.");
  *script = read_script(text);
  if (!script->problem.empty()) return console->usage_error(file, script->problem + ".");
  return cli::kDone;
}

int view(const Arguments& a) {
  cli::Console console(a.quiet);
  Messages messages;
  const hd::DiagnosticSink print = console.sink();
  const hd::DiagnosticSink sink = [&](const hd::Diagnostic& d) {
    print(d);
    messages.add(d);
  };
  WindowOptions options;
  if (const int code = load_script(a.script, &options.script, &console); code != cli::kDone) return code;
  if (const int code = check_scene_arguments(a.scene, console); code != cli::kDone) return code;
  hd::description::LoadOptions load = scene_load_options(a.scene);
  load.keep_going = true;  // an image that is missing is a message in the window, and may appear
  cli::SceneSession session;
  if (const int code = load_scene(a.scene, load, console, sink, &session); code != cli::kDone) return code;
  for (const std::string& note : session.file.notes) messages.add({hd::Severity::info, "scene.note", "", note});
  if (!session.start(sink)) return cli::kRender;
  options.scene_file = a.scene.scene;
  options.title = std::filesystem::path(a.scene.scene).filename().string() + " - Alabaster";
  ViewSession shown(&session, sink);
  return run_window(&shown, &messages, options, &console);
}

int run(int argc, char** argv) {
  CLI::App app("A window on a scene: look around, pick, edit, save.", "alabaster view");
  Arguments a;
  cli::add_scene_options(&app, &a.scene);
  app.add_option("--script", a.script, "Acts as the lines of this file say, as a user would (delegate/view/script.h)")
      ->type_name("FILE");
  app.add_flag("--quiet", a.quiet, "Print errors and warnings only");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    std::ostringstream errors;
    const int code = app.exit(e, std::cout, errors);
    std::cerr << cli::without_control_characters(errors.str(), "\n");
    return code == 0 ? cli::kDone : cli::kUsage;
  }
  return view(a);
}

}  // namespace
}  // namespace alabaster::view

int main(int argc, char** argv) {
  try {
    return alabaster::view::run(argc, argv);
  } catch (const std::bad_alloc&) {
    std::fputs("error: not enough memory\n", stderr);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "error: %s\n", e.what());
  }
  return alabaster::cli::kRender;
}
