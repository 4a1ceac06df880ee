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
  std::optional<double> time;                   // seconds, or the time code of a stage
  std::string model_scene, animation, variant;  // of a glTF model: name or index
  std::vector<std::string> overrides;
  bool allow_outside = false;
  hd::host::StageOptions stage;
  std::optional<int> complexity;
};

/// Adds SCENE, --set, --allow-outside and the options of stages.
void add_scene_file(CLI::App* command, SceneArguments* arguments);
/// What reading a stage may take and reach.
void add_stage_reading(CLI::App* command, SceneArguments* arguments);
/// usdrecord's words, and those of its levels.
std::optional<int> parse_complexity(const std::string& text);
void add_ocio(CLI::App* command, SceneArguments* arguments);
/// Adds SCENE, --camera, --time, --scene, --animation, --variant, --dome, --ocio, --set, --allow-outside and
/// the options of stages.
void add_scene_options(CLI::App* command, SceneArguments* arguments);

/// `flags`: those of the command that set a value; --set comes over them.
hd::description::LoadOptions scene_load_options(const SceneArguments& arguments,
                                                std::vector<hd::description::Override> flags = {});
/// Loads the scene, chooses its colours and prints its notes. `sink` shows reports in the console, too. Ends the
/// command if it cannot be loaded.
void open_scene(const SceneArguments& arguments, const hd::description::LoadOptions& options, Console& console,
                const hd::DiagnosticSink& sink, SceneSession* session);

}  // namespace alabaster::cli
