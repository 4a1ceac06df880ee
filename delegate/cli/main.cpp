// The program alabaster: the first host. It uses the public contract and the kit, nothing else.
#include <CLI/CLI.hpp>

#include "delegate/api/render_delegate.h"
#include "delegate/cli/commands.h"
#include "delegate/cli/exit_codes.h"

namespace alabaster::cli {
namespace {

constexpr const char* kExitCodes =
    "Exit codes: 0 done, 2 usage, 3 input, 4 render failed, 5 output, 130 interrupted (what there was is written and "
    "marked incomplete).";

CLI::App* add_render(CLI::App& app, RenderArguments* a) {
  CLI::App* c = app.add_subcommand("render", "Renders a scene (.gltf, .glb or a render description .json) to files.");
  c->add_option("scene", a->scene, "The scene")->required()->type_name("SCENE");
  c->add_option("-o,--output", a->outputs, "File to write: .exr .png .tif .jpg; may be given several times")
      ->type_name("FILE")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  c->add_option("--camera", a->camera, "Camera to look through")->type_name("NAME");
  c->add_option("--time", a->time, "Frame number, whole")->type_name("N");
  c->add_option("--size", a->size, "Resolution in pixels")->type_name("WxH");
  c->add_option("--crop", a->crop, "Part to render, in pixels, y down")->type_name("X0,Y0,X1,Y1");
  c->add_option(
       "--quality", a->quality,
       "preview, draft, production or reference: settings that were measured to be worth their time (alabaster "
       "schema quality_presets). They win over the scene's own; every other flag wins over them. A preset ends at "
       "its own targetError unless --target-error says otherwise")
      ->type_name("PRESET");
  c->add_option(
       "--spp", a->samples,
       "Samples per pixel, at most; with --quality a render still ends at the preset's targetError, if that is sooner")
      ->type_name("N");
  c->add_option("--target-error", a->target_error,
                "Ends when the noise is below this relative RMSE (0.02: two per cent)")
      ->type_name("E");
  c->add_option("--time-limit", a->time_limit, "Ends after so many seconds of rendering")->type_name("S");
  c->add_option("--seed", a->seed, "Another noise pattern")->type_name("N");
  c->add_option("--threads", a->threads, "Render threads; 0: all cores")->type_name("N");
  c->add_option("--max-depth", a->max_depth, "Bounces between surfaces")->type_name("N");
  c->add_option("--subsurface", a->subsurface, "lambert, walk, reference, diffusion or auto")->type_name("MODE");
  c->add_option("--inversion", a->inversion, "chiang2016, exact or vanDeHulst")->type_name("NAME");
  c->add_option("--dome", a->dome, "Dome light: an image, or a colour as one or three numbers; then an intensity")
      ->type_name("FILE|COLOR[,I]");
  c->add_option("--display", a->display, "Display of the OCIO config, for .png .tif .jpg")->type_name("NAME");
  c->add_option("--view", a->view, "View of the display")->type_name("NAME");
  c->add_option("--look", a->look, "Look of the OCIO config")->type_name("NAME");
  c->add_option("--exposure", a->exposure, "Stops, before the view")->type_name("STOPS");
  c->add_option("--ocio", a->ocio, "OpenColorIO config; else the scene's, $OCIO, or the built-in one")
      ->type_name("FILE");
  c->add_option("--aov", a->aovs,
                "Further layer of every .exr: depth, normal, albedo, primId, diffuse, subsurface, specular, emission, "
                "error, ...; several times")
      ->type_name("NAME")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  c->add_option("--set", a->overrides,
                "samples=16, materials/NAME.roughness=0.3, lights/NAME.intensity=2, meshes/NAME.refineLevel=3, "
                "camera.fStop=2.8; several times")
      ->type_name("KEY=VALUE")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  c->add_option("--stats", a->stats, "Writes what the render cost as JSON")->type_name("FILE.json");
  c->add_flag("--quiet", a->quiet, "Only errors");
  c->footer(kExitCodes);
  return c;
}

CLI::App* add_tradeoff(CLI::App& app, TradeoffArguments* a) {
  CLI::App* c = app.add_subcommand(
      "tradeoff", "Measures speed against accuracy on a scene: every rung and knob, noise and bias told apart.");
  c->add_option("scene", a->scene, "The scene")->required()->type_name("SCENE");
  c->add_option("-o,--output", a->folder,
                "Folder for tradeoff.csv, .json, .md, .svg, .png and the state to go on from; else SCENE_tradeoff")
      ->type_name("DIR");
  c->add_option("--budget", a->budget, "Time to render in, earlier runs in the same folder included; else 10")
      ->type_name("MINUTES");
  c->add_option("--size", a->size, "Resolution in pixels; else the scene's, or as much of it as the budget allows")
      ->type_name("WxH");
  c->add_option("--only", a->only,
                "Measures only configurations whose name this finds, and walk; '^quality=': the presets")
      ->type_name("REGEX");
  c->add_option("--set", a->overrides, "As for render")
      ->type_name("KEY=VALUE")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  c->add_flag("--restart", a->restart, "Begins anew where the folder holds an earlier study");
  c->add_flag("--quiet", a->quiet, "Only errors");
  c->footer(kExitCodes);
  return c;
}

int run(int argc, char** argv) {
  CLI::App app("Alabaster, a path tracer for translucent things.", "alabaster");
  app.set_version_flag("--version", std::string(AlabasterVersions()));
  app.require_subcommand(1);
  app.footer(kExitCodes);
  RenderArguments render;
  InfoArguments info;
  OcioArguments ocio;
  TradeoffArguments tradeoff;
  std::string schema;
  const CLI::App* render_command = add_render(app, &render);
  const CLI::App* tradeoff_command = add_tradeoff(app, &tradeoff);
  CLI::App* info_command = app.add_subcommand("info", "Says what is in a scene and what rendering it requires.");
  info_command->add_option("scene", info.scene, "The scene")->required()->type_name("SCENE");
  info_command->add_option("--set", info.overrides, "As for render")
      ->type_name("KEY=VALUE")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  info_command
      ->add_option("--predict", info.predict,
                   "From a probe of a few seconds: what rendering to this relative RMSE takes (0.02: two per cent)")
      ->type_name("E");
  info_command->add_option("--size", info.size, "Resolution in pixels, for --predict")->type_name("WxH");
  info_command->add_option("--threads", info.threads, "Render threads, for --predict; 0: all cores")->type_name("N");
  CLI::App* schema_command = app.add_subcommand("schema", "Prints a JSON schema: every parameter there is.");
  schema_command
      ->add_option("name", schema,
                   "disney_material, lights, camera, render_settings, render_description or quality_presets")
      ->required()
      ->type_name("NAME");
  CLI::App* ocio_command = app.add_subcommand("ocio", "Lists colour spaces, displays, views and looks.");
  ocio_command->add_option("--ocio", ocio.ocio, "OpenColorIO config")->type_name("FILE");
  ocio_command->add_flag("--export", ocio.write_config, "Prints the config itself, to keep or change");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? kDone : kUsage;
  }
  if (render_command->parsed()) return run_render(render);
  if (tradeoff_command->parsed()) return run_tradeoff(tradeoff);
  if (info_command->parsed()) return run_info(info);
  if (schema_command->parsed()) return run_schema(schema);
  return run_ocio(ocio);
}

}  // namespace
}  // namespace alabaster::cli

int main(int argc, char** argv) {
  try {
    return alabaster::cli::run(argc, argv);
  } catch (const std::bad_alloc&) {
    std::fputs("error: not enough memory\n", stderr);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "error: %s\n", e.what());
  }
  return alabaster::cli::kRender;
}
