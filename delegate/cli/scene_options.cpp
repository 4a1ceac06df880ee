#include "delegate/cli/scene_options.h"

#include <CLI/CLI.hpp>
#include <algorithm>

#include "delegate/cli/exit_codes.h"
#include "delegate/cli/flags.h"

namespace alabaster::cli {
namespace {

struct TextFlag {
  const char* flag;
  std::string SceneArguments::*value;
  const char *type, *help;
};
constexpr TextFlag kFlags[] = {
    {"--camera", &SceneArguments::camera, "NAME", "Camera to render from"},
    {"--scene", &SceneArguments::model_scene, "N|NAME", "Scene of the glTF file; default: the file's own choice"},
    {"--animation", &SceneArguments::animation, "N|NAME", "Animation of the glTF file; default: the first"},
    {"--variant", &SceneArguments::variant, "N|NAME",
     "Variant of the glTF file's materials; of a stage /PRIM{SET=CHOICE}, several one after the other"},
    {"--dome", &SceneArguments::dome, "FILE|COLOR[,I]",
     "Dome light: an image, or a colour as one or three numbers; optionally an intensity"},
};

void add_allow_outside(CLI::App* command, SceneArguments* a) {
  command->add_flag("--allow-outside", a->allow_outside,
                    "Let scene files name files that lie outside their own folders, for reading and for writing");
}

}  // namespace

std::optional<int> parse_complexity(const std::string& text) {
  constexpr const char* kWords[] = {"low", "medium", "high", "veryhigh"};
  for (int level = 0; level < 4; ++level)
    if (text == kWords[level]) return level;
  return std::nullopt;
}

namespace {

// Of stages of OpenUSD.
void add_stage_options(CLI::App* command, SceneArguments* a) {
  hd::host::StageOptions* stage = &a->stage;
  command->add_option("--session-layer", stage->session_layer, "Layer over a stage of OpenUSD")->type_name("FILE");
  add_repeated(command, "--mask", &stage->mask, "PATH", "Read this prim of a stage and what it needs; may be repeated");
  command
      ->add_option("--purposes", stage->purposes,
                   "Purposes of a stage that are drawn, such as default,proxy; default: those of its settings, else "
                   "default,render")
      ->type_name("LIST")
      ->allow_extra_args(false)
      ->delimiter(',');
  command
      ->add_option("--render-settings", stage->settings, "RenderSettings prim of a stage; default: the stage's choice")
      ->type_name("PATH");
  command
      ->add_option("--pass", stage->pass,
                   "RenderPass prim of a stage: its settings, and what it prunes, shows and holds out")
      ->type_name("PATH");
  add_parsed(command, "--complexity", &a->complexity, parse_complexity, "is not low, medium, high or veryhigh.",
             "LEVEL",
             "Refinement of a stage's subdivision surfaces: low (none), medium, high (the default) or veryhigh");
  add_stage_reading(command, a);
}

}  // namespace

void add_stage_reading(CLI::App* command, SceneArguments* a) {
  hd::host::StageOptions* stage = &a->stage;
  add_repeated(command, "--search-path", &stage->search_paths, "FOLDER",
               "Search path of a stage's assets, which may be read, too; may be repeated");
  add_repeated(command, "--allow", &stage->allowed_folders, "FOLDER",
               "Folder besides its own that a stage may read files of; may be repeated");
  add_parsed(command, "--usd-limit", &stage->seconds, parse_positive, "is not a number of seconds above 0.", "S",
             "CPU time that opening or reading a stage may take; default: 30");
  add_allow_outside(command, a);
}

void add_scene_file(CLI::App* command, SceneArguments* a) {
  command->add_option("file", a->scene, "Scene file")->required()->type_name("SCENE");
  add_repeated(command, "--set", &a->overrides, "KEY=VALUE", "Override a value, as in render");
  command->add_option("--variant", a->variant, "Variant of the model, as in render")->type_name("NAME");
  add_stage_options(command, a);
}

void add_ocio(CLI::App* command, SceneArguments* a) {
  command->add_option("--ocio", a->ocio, "OpenColorIO config; default: the scene's, else $OCIO, else the built-in one")
      ->type_name("FILE");
}

void add_scene_options(CLI::App* command, SceneArguments* a) {
  command
      ->add_option("file", a->scene,
                   "Scene file (.gltf, .glb, .usd, .usda, .usdc, .usdz, .alab or a render description .json)")
      ->required()
      ->type_name("SCENE");
  for (const TextFlag& flag : kFlags) command->add_option(flag.flag, a->*flag.value, flag.help)->type_name(flag.type);
  add_ocio(command, a);
  add_parsed(
      command, "--time", &a->time, parse_nonnegative, "is not a time: write a number of seconds from 0 up.", "S",
      "Time in the models' animation in seconds, of a stage its time code; without it they keep the pose in which they "
      "are authored, a stage its start");
  add_repeated(command, "--set", &a->overrides, "KEY=VALUE",
               "Override a value: samples=16, materials/NAME.roughness=0.3, lights/NAME.intensity=2, "
               "meshes/NAME.refineLevel=3, camera.fStop=2.8; may be repeated");
  add_stage_options(command, a);
}

hd::description::LoadOptions scene_load_options(const SceneArguments& a, std::vector<hd::description::Override> flags) {
  hd::description::LoadOptions options;
  options.are_flags = true;
  options.overrides = std::move(flags);
  for (const std::string& assignment : a.overrides)
    options.overrides.emplace_back(assignment).origin = "--set " + assignment;
  options.camera = a.camera;
  options.dome = a.dome;
  options.time = a.time;
  options.stage = a.stage, options.complexity = a.complexity;
  options.scene = a.model_scene;
  options.animation = a.animation;
  options.variant = a.variant;
  options.allow_outside = a.allow_outside;
  return options;
}

void open_scene(const SceneArguments& a, const hd::description::LoadOptions& options, Console& console,
                const hd::DiagnosticSink& sink, SceneSession* session) {
  session->load(a.scene, options, sink);
  session->choose_colors(a.ocio, sink, kInput);
  for (const std::string& note : session->file.notes) console.note("note: " + note);
  const auto& models = session->file.models;
  if ((options.time || options.frame) &&
      std::all_of(models.begin(), models.end(), [](const auto& m) { return m.animations.empty() && !m.varies; }))
    sink({hd::Severity::warning, "render.time", a.scene, "It has no animation: every time shows the same."});
}

}  // namespace alabaster::cli
