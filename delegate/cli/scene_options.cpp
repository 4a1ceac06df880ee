#include "delegate/cli/scene_options.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>

#include "delegate/cli/exit_codes.h"

namespace alabaster::cli {
namespace {

struct TextFlag {
  const char* flag;
  std::string SceneArguments::*value;
  const char *type, *help;
};
constexpr TextFlag kFlags[] = {
    {"--camera", &SceneArguments::camera, "NAME", "Camera to render from"},
    {"--time", &SceneArguments::time, "S",
     "Time in the models' animation in seconds; without it they keep the pose in which they are authored"},
    {"--scene", &SceneArguments::model_scene, "N|NAME", "Scene of the glTF file; default: the file's own choice"},
    {"--animation", &SceneArguments::animation, "N|NAME", "Animation of the glTF file; default: the first"},
    {"--variant", &SceneArguments::variant, "N|NAME", "Variant of the glTF file's materials"},
    {"--dome", &SceneArguments::dome, "FILE|COLOR[,I]",
     "Dome light: an image, or a colour as one or three numbers; optionally an intensity"},
    {"--ocio", &SceneArguments::ocio, "FILE",
     "OpenColorIO config; default: the scene's, else $OCIO, else the built-in one"},
};

}  // namespace

void add_repeated(CLI::App* command, const char* flags, std::vector<std::string>* values, const char* type,
                  const char* help) {
  command->add_option(flags, *values, help)
      ->type_name(type)
      ->expected(1)
      ->allow_extra_args(false)  // or "--" after a value would end the values alone, and not the options
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

void add_allow_outside(CLI::App* command, bool* allowed) {
  command->add_flag("--allow-outside", *allowed,
                    "Let scene files name files that lie outside their own folders, for reading and for writing");
}

void add_scene_options(CLI::App* command, SceneArguments* a) {
  command->add_option("file", a->scene, "Scene file (.gltf, .glb, .alab or a render description .json)")
      ->required()
      ->type_name("SCENE");
  for (const TextFlag& flag : kFlags) command->add_option(flag.flag, a->*flag.value, flag.help)->type_name(flag.type);
  add_repeated(command, "--set", &a->overrides, "KEY=VALUE",
               "Override a value: samples=16, materials/NAME.roughness=0.3, lights/NAME.intensity=2, "
               "meshes/NAME.refineLevel=3, camera.fStop=2.8; may be repeated");
  add_allow_outside(command, &a->allow_outside);
}

std::optional<double> parse_nonnegative(const std::string& text) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const bool whole = error == std::errc() && end == text.data() + text.size();
  return whole && number >= 0 && std::isfinite(number) ? std::optional(number) : std::nullopt;
}

int check_scene_arguments(const SceneArguments& a, Console& console) {
  if (a.time.empty() || parse_nonnegative(a.time)) return kDone;
  return console.usage_error("--time", "'" + a.time + "' is not a time: write a number of seconds from 0 up.");
}

hd::description::LoadOptions scene_load_options(const SceneArguments& a) {
  hd::description::LoadOptions options;
  options.overrides = a.overrides;
  options.camera = a.camera;
  options.dome = a.dome;
  options.time = parse_nonnegative(a.time);
  options.scene = a.model_scene;
  options.animation = a.animation;
  options.variant = a.variant;
  options.allow_outside = a.allow_outside;
  return options;
}

int load_scene(const SceneArguments& a, const hd::description::LoadOptions& options, Console& console,
               const hd::DiagnosticSink& sink, SceneSession* session) {
  if (const int code = session->load(a.scene, options, sink); code != kDone) return code;
  if (!session->choose_colors(a.ocio, sink)) return kInput;
  for (const std::string& note : session->file.notes) console.note("note: " + note);
  const auto& models = session->file.gltf;
  if (options.time && std::all_of(models.begin(), models.end(), [](const auto& m) { return m.animations.empty(); }))
    sink({hd::Severity::warning, "render.time", a.scene, "It has no animation: every time shows the same."});
  return kDone;
}

}  // namespace alabaster::cli
