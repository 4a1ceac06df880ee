#include "delegate/archive/archive.h"
#include "delegate/cli/commands.h"
#include "delegate/cli/exit_codes.h"
#include "delegate/cli/interrupt.h"

namespace alabaster::cli {

int run_convert(const ConvertArguments& arguments) {
  catch_interrupts();
  Console console(false);
  if (!arguments.output.ends_with(".alab"))
    console.usage_error("--output", "'" + arguments.output + "' is not the name of a scene archive: write NAME.alab.");
  SceneSession session;
  hd::description::LoadOptions options = scene_load_options(arguments);
  options.size = arguments.size;
  open_scene(arguments, options, console, console.sink(), &session);
  console.require_usage("--output", input_overwritten({arguments.output}, session, arguments.scene));
  hd::archive::SceneInfo info = session.file.info;
  info.settings = session.file.settings;
  info.color_config = {session.colors().ocio, session.colors().ocio, nullptr};
  info.names = session.scene.GetNames();
  set_writing(true);
  console.require(kOutput, arguments.output,
                  hd::archive::WriteArchive(arguments.output, session.scene.GetPrims(), info,
                                            {.embed_images = arguments.embed, .sink = console.sink()}));
  return kDone;
}

}  // namespace alabaster::cli
