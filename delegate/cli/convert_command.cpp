#include "delegate/archive/archive.h"
#include "delegate/cli/commands.h"
#include "delegate/cli/exit_codes.h"
#include "delegate/cli/interrupt.h"
#include "delegate/cli/outputs.h"
#include "delegate/cli/scene_inputs.h"

namespace alabaster::cli {

int run_convert(const ConvertArguments& arguments) {
  catch_interrupts();
  Console console(false);
  if (!arguments.output.ends_with(".alab"))
    return console.usage_error("--output",
                               "'" + arguments.output + "' is not the name of a scene archive: write NAME.alab.");
  if (const std::string fault = size_fault(arguments.size); !fault.empty()) return console.usage_error("--size", fault);
  if (const int code = check_scene_arguments(arguments, console); code != kDone) return code;
  SceneSession session;
  hd::description::LoadOptions options = scene_load_options(arguments);
  if (const auto size = parse_size(arguments.size))
    options.overrides.push_back("resolution=[" + std::to_string(size->x) + "," + std::to_string(size->y) + "]");
  if (const int code = load_scene(arguments, options, console, console.sink(), &session); code != kDone) return code;
  if (const std::string fault = input_overwritten({arguments.output}, session, arguments.scene); !fault.empty())
    return console.usage_error("--output", fault);
  const hd::archive::SceneInfo info = {session.file.settings, {session.colors().ocio, session.colors().ocio, nullptr}};
  const std::string fault = hd::archive::WriteArchive(arguments.output, hd::archive::PrimsOf(session.scene), info,
                                                      {.embed_images = arguments.embed, .sink = console.sink()});
  if (fault.empty()) return kDone;
  console.error(arguments.output, fault);
  return kOutput;
}

}  // namespace alabaster::cli
