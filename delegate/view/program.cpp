// The program alabaster-view: a window on a scene. It uses the public contract and the kit, nothing else.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "delegate/cli/command_words.h"
#include "delegate/cli/exit_codes.h"
#include "delegate/cli/flags.h"
#include "delegate/cli/scene_options.h"
#include "delegate/view/window.h"

namespace alabaster::view {
namespace {

struct Arguments {
  cli::SceneArguments scene;
  bool quiet = false;
};

int view(const Arguments& a, WindowDriver* driver) {
  cli::Console console(a.quiet);
  Messages messages;
  const hd::DiagnosticSink print = console.sink();
  const hd::DiagnosticSink sink = [&](const hd::Diagnostic& d) {
    print(d);
    messages.add(d);
  };
  WindowOptions options;
  options.driver = driver;
  hd::description::LoadOptions load = scene_load_options(a.scene);
  load.keep_going = true;  // an image that is missing is a message in the window, and may appear
  const auto open = [&] {
    auto session = std::make_unique<cli::SceneSession>();
    open_scene(a.scene, load, console, sink, session.get());
    for (const std::string& note : session->file.notes) messages.add({hd::Severity::info, "scene.note", "", note});
    session->start(sink);
    return session;
  };
  options.scene_file = a.scene.scene;
  options.title = std::filesystem::path(a.scene.scene).filename().string() + " - Alabaster";
  const auto begun = SceneReload::Time::clock::now();
  ViewSession shown(open(), sink);
  SceneReload reload(open, a.scene.scene, shown.loaded(), begun, sink);
  return run_window(&shown, &reload, &messages, options, &console);
}

int run(int argc, char** argv, WindowDriver* driver) {
  CLI::App app("A window on a scene: look around, pick, edit, light, compare, save.", "alabaster view");
  Arguments a;
  cli::Words words{"view"};
  words.insert(words.end(), argv + std::min(argc, 1), argv + argc);
  cli::add_scene_options(&app, &a.scene);
  app.add_flag("--quiet", a.quiet, "Print errors and warnings only");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return cli::parse_fault(e, app, cli::command_fault(app, words, e));
  }
  return view(a, driver);
}

}  // namespace

int run_program(int argc, char** argv, WindowDriver* driver) {
  try {
    return run(argc, argv, driver);
  } catch (const cli::Exit& exit) {
    return exit.code;
  } catch (const std::bad_alloc&) {
    std::fputs("error: not enough memory\n", stderr);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "error: %s\n", e.what());
  }
  return cli::kRender;
}

}  // namespace alabaster::view
