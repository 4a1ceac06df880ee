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
    {"--variant", &SceneArguments::variant, "N|NAME", "Variant of the glTF file's materials"},
    {"--dome", &SceneArguments::dome, "FILE|COLOR[,I]",
     "Dome light: an image, or a colour as one or three numbers; optionally an intensity"},
};

void add_allow_outside(CLI::App* command, SceneArguments* a) {
  command->add_flag("--allow-outside", a->allow_outside,
                    "Let scene files name files that lie outside their own folders, for reading and for writing");
}

}  // namespace

void add_scene_file(CLI::App* command, SceneArguments* a) {
  command->add_option("file", a->scene, "Scene file")->required()->type_name("SCENE");
  add_repeated(command, "--set", &a->overrides, "KEY=VALUE", "Override a value, as in render");
  add_allow_outside(command, a);
}

void add_ocio(CLI::App* command, SceneArguments* a) {
  command->add_option("--ocio", a->ocio, "OpenColorIO config; default: the scene's, else $OCIO, else the built-in one")
      ->type_name("FILE");
}

void add_scene_options(CLI::App* command, SceneArguments* a) {
  command->add_option("file", a->scene, "Scene file (.gltf, .glb, .alab or a render description .json)")
      ->required()
      ->type_name("SCENE");
  for (const TextFlag& flag : kFlags) command->add_option(flag.flag, a->*flag.value, flag.help)->type_name(flag.type);
  add_ocio(command, a);
  add_parsed(command, "--time", &a->time, parse_nonnegative, "is not a time: write a number of seconds from 0 up.", "S",
             "Time in the models' animation in seconds; without it they keep the pose in which they are authored");
  add_repeated(command, "--set", &a->overrides, "KEY=VALUE",
               "Override a value: samples=16, materials/NAME.roughness=0.3, lights/NAME.intensity=2, "
               "meshes/NAME.refineLevel=3, camera.fStop=2.8; may be repeated");
  add_allow_outside(command, a);
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
