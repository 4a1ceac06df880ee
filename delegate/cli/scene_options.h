// The options of a scene that the programs share: which part of it, when, and changes to it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "delegate/cli/scene_session.h"

namespace CLI {
class App;
}

namespace alabaster::cli {

/// Arguments as given; empty if not given.
struct SceneArguments {
  std::string scene;
  std::string camera, dome, ocio;
  std::string time;                             // seconds
  std::string model_scene, animation, variant;  // of a glTF model: name or index
  std::vector<std::string> overrides;
  bool allow_outside = false;
};

/// Adds SCENE, --camera, --time, --scene, --animation, --variant, --dome, --ocio, --set and --allow-outside.
void add_scene_options(CLI::App* command, SceneArguments* arguments);
/// An option that may be given several times, each time with one value.
void add_repeated(CLI::App* command, const char* flags, std::vector<std::string>* values, const char* type,
                  const char* help);
void add_allow_outside(CLI::App* command, bool* allowed);

/// Parses a number of seconds or of frames per second, finite and not negative. Empty if malformed.
std::optional<double> parse_nonnegative(const std::string& text);

/// Refuses what is malformed before the scene is read; an exit code.
int check_scene_arguments(const SceneArguments& arguments, Console& console);
/// For arguments that check_scene_arguments() accepts.
hd::description::LoadOptions scene_load_options(const SceneArguments& arguments);
/// Loads the scene, chooses its colours and prints its notes. `sink` shows reports in the console, too. An exit code.
int load_scene(const SceneArguments& arguments, const hd::description::LoadOptions& options, Console& console,
               const hd::DiagnosticSink& sink, SceneSession* session);

}  // namespace alabaster::cli
