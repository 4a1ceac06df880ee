// The program alabaster: its commands and their flags.
#include <fcntl.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <functional>
#include <iostream>
#include <set>

#include "delegate/api/render_delegate.h"
#include "delegate/cli/commands.h"
#include "delegate/cli/console.h"
#include "delegate/cli/exit_codes.h"

namespace alabaster::cli {
namespace {

constexpr const char* kExitCodes =
    "Exit codes: 0 success, 2 bad usage, 3 bad input (a damaged image included), 4 render failed or memory ran out, 5 "
    "output failed, 6 rendered with --keep-going without all that the scene names, 130 interrupted (the picture so far "
    "is written and marked incomplete, of --frames those that are done). After 2 and 3 nothing was rendered.";

/// A flag that only names a setting. CLI11 runs callbacks in the order of this table, so --quality stays its first row:
/// the others override settings of the preset.
struct SettingFlag {
  const char *flag, *setting, *type, *help;
};
constexpr SettingFlag kSettingFlags[] = {
    {"--quality", "quality", "PRESET",
     "preview, draft, production or reference: measured settings (alabaster schema quality_presets). A "
     "preset overrides the scene's settings, and every other flag overrides the preset. A render ends at "
     "the preset's targetError unless --target-error is given"},
    {"--spp", "samples", "N",
     "Samples per pixel, at most. Default: the scene's, else 64; with --target-error or --time-limit 65536. With "
     "--quality the render still ends at the preset's targetError if that comes first"},
    {"--target-error", "targetError", "E",
     "End when the noise of the picture as rendered, before any denoising, is below this relative RMSE (0.02 is two "
     "per cent), or at --spp samples per pixel if that comes first"},
    {"--time-limit", "timeLimit", "S",
     "End after this many seconds of rendering, loading before not counted, or at --spp samples per pixel (65536 "
     "unless given) if that comes first. A pixel that has no "
     "sample by then may take its first one up to half a second later. If pixels are left without a sample, a warning, "
     "the statistics and the EXR (pixelsWithoutSample) tell how many; AOV sampleCount is 0 there, and blocks of pixels "
     "without any sample have alpha 0. Denoising comes after the limit"},
    {"--seed", "seed", "N", "Seed of the noise pattern"},
    {"--threads", "threads", "N", "Render threads; 0 uses all cores"},
    {"--max-depth", "maxDepth", "N", "Bounces between surfaces, at most"},
    {"--subsurface", "subsurface", "MODE", "walk, reference, diffusion or lambert"},
    {"--studio", "studio", "MODE",
     "auto, on or off: lights and a backdrop around the objects. auto adds them to a scene without light, and the "
     "backdrop only if it has no camera either; on replaces the scene's lights; off adds a soft dome to a scene "
     "without light"},
    {"--inversion", "inversion", "NAME", "chiang2016 or exact"},
    {"--memory-limit", "memoryLimit", "MIB",
     "Memory for the scene and the frame: more is refused. Default: three quarters of what the program "
     "may use"},
    {"--texture-memory", "textureMemory", "MIB",
     "Memory for the texels of images; more texels are read from a temporary file as they are needed. Default: 4096"},
};

void add_checkpoint(CLI::App* c, RenderArguments* a) {
  c->add_option(
       "--checkpoint", a->checkpoint,
       "File that the state of the render is written to every minute, when it is interrupted and at its end. A "
       "killed render loses no more than that. With --frames: part.####.checkpoint")
      ->type_name("FILE");
  add_parsed(c, "--checkpoint-interval", &a->checkpoint_interval, parse_nonnegative,
             "is not a number of seconds from 0 up.", "S", "Seconds between two checkpoints; default: 60");
  c->add_flag("--resume", a->resume,
              "Continue from the --checkpoint FILE, to the very bits of a render that nothing interrupted; without the "
              "file, begin. It must be of the same scene, settings and version. --spp may be raised, and --time-limit "
              "counts the time before, too");
  add_parsed(
      c, "--samples", &a->samples, parse_samples,
      "is not a range of samples: write begin:end, such as 256:512 for the samples from 256 to 511; end is at "
      "most 1048576. --spp N is the number of samples per pixel.",
      "A:B",
      "Take samples A to B - 1 of each pixel only: a part of a frame of B or more, which 'alabaster merge' "
      "adds to the others. Needs --checkpoint, which the part is written to; files of -o show the part alone. With "
      "--keep-going a part ends with exit code 0, and the merge with 6");
}

void add_display(CLI::App* c, PictureArguments* a) {
  c->add_option("--display", a->display, "Display of the OCIO config, for .png, .tif and .jpg")->type_name("NAME");
  c->add_option("--view", a->view, "View of that display")->type_name("NAME");
  add_parsed(c, "--exposure", &a->exposure, parse_stops, "is not a number of stops from -64 to 64.", "STOPS",
             "Exposure in stops, applied before the view");
}

/// The options of pictures but for --denoise and --ocio.
void add_picture_options(CLI::App* c, PictureArguments* a, const char* aov_help) {
  add_repeated(c, "-o,--output", &a->outputs, "FILE", "File to write: .exr, .png, .tif or .jpg; may be repeated");
  add_display(c, a);
  c->add_option("--look", a->look, "Look of the OCIO config")->type_name("NAME");
  add_repeated(c, "--aov", &a->aovs, "NAME[=LAYER]", aov_help);
  c->add_option(
       "--compression", a->compression,
       "Compression of .exr: none, rle, zip (the default), zips, piz; pxr24, b44, b44a, dwaa and dwab lose bits")
      ->type_name("NAME");
  add_parsed(c, "--tiles", &a->tiles, parse_tiles, "is no side of tiles: give 16 to 256, or 0 for scanlines.", "N",
             "Tiles of .exr, of N x N pixels: 16 to 256; 0 (the default): scanlines");
}

constexpr const char* kNoFrames =
    "is no list of frames, at most 100000: write 101, 101:105, 105:101, 101:109x2 or 101:104x0.5, several between "
    "commas.";

void add_frames(CLI::App* c, RenderArguments* a) {
  add_parsed(
      c, "--frames", &a->frames, parse_frames, kNoFrames, "LIST",
      "Render these frames, each to files of its own: -o frame.####.exr, frame.%04d.exr or frame.$F4.exr. 1:5 is "
      "a range, 1:9x2 every second frame, 1,7:9 a list. Frame N shows the models at N / fps seconds, or at the "
      "stage's time code N, and has a noise pattern of its own");
  add_parsed(c, "--start-frame", &a->start_frame, parse_frame, "is not a whole number.", "N",
             "The frame that shows models of glTF at 0 seconds; default: 0");
  add_parsed(c, "--turntable", &a->turntable, parse_tasks, "is not a whole number from 1 to 10000.", "N",
             "Render one turn of the camera about the objects in N frames, 1 to N unless --frames chooses some. The "
             "models keep their pose");
  c->add_flag("--turntable-lights", a->turntable_lights, "Turn the lights with the camera");
  c->add_flag("--skip-existing", a->skip_existing,
              "Leave out the frames whose files are there already, whole and of the frame's size");
}

void add_shutter(CLI::App* c, RenderArguments* a) {
  add_parsed(c, "--fps", &a->fps, parse_positive, "is not a number of frames per second above 0.", "N",
             "Frames per second, for --frames and --shutter; default: 24");
  add_parsed(c, "--shutter", &a->shutter, parse_interval, "is not a shutter: write open:close in frames.", "OPEN:CLOSE",
             "Motion blur: when the shutter opens and closes, in frames relative to the frame that is drawn, such as "
             "0:0.5 or -0.25:0.25. Default: the camera's own, else closed at once");
}

void add_setting_flags(CLI::App* c, RenderArguments* a) {
  for (const SettingFlag& flag : kSettingFlags)
    c->add_option_function<std::string>(
         flag.flag,
         [a, &flag](const std::string& text) {
           a->settings.emplace_back(std::string(flag.flag) + " " + text, flag.setting, text);
         },
         flag.help)
        ->type_name(flag.type);
}

void add_keep_going(CLI::App* c, bool* keep_going) {
  c->add_flag("--keep-going", *keep_going,
              "Render although an image is missing or damaged, or an object or light cannot be built: without it. The "
              "files are marked (alabaster/sceneFaults), --stats lists what is missing, and the exit code is 6");
}

/// The options that decide one frame, and what it costs.
void add_frame_options(CLI::App* c, RenderArguments* a) {
  add_scene_options(c, a);
  add_picture_options(c, a,
                      "Extra layer for every .exr: depth, normal, albedo, primId, diffuse, subsurface, specular, "
                      "emission, error, ...; =LAYER gives the layer a name of its own; may be repeated");
  add_shutter(c, a);
  add_size(c, &a->size, "Resolution in pixels");
  add_parsed(c, "--crop", &a->crop, parse_crop,
             "is not a rectangle: write four whole numbers, x0,y0,x1,y1, each from -2147483648 to 2147483647.",
             "X0,Y0,X1,Y1", "Region to render, in pixels from the upper left corner");
  add_setting_flags(c, a);
  c->add_flag(
      "--denoise", a->denoise,
      "Denoise the picture after its last sample (Open Image Denoise 2, if installed): .png, .tif and .jpg show "
      "it denoised, and .exr gets it as layer 'denoised' beside the colour as rendered");
}

/// The options of render but for those of checkpoints.
void add_render_options(CLI::App* c, RenderArguments* a) {
  add_frame_options(c, a);
  add_frames(c, a);
  add_parsed(c, "--pixel", &a->pixel, parse_pixel,
             "is not a pixel: write x,y or x,y,sample, for example 320,200 or 320,200,5.", "X,Y[,SAMPLE]",
             "Print the path of one sample of a pixel, vertex by vertex, instead of writing files. X and Y count from "
             "the upper left corner of the frame; pixels beyond its edges (overscan) are allowed if the scene's crop "
             "has them. Without SAMPLE, list the samples that the pixel has without adaptive sampling, and follow "
             "the brightest");
  c->add_option("--stats", a->stats,
                "Write the render's statistics as JSON; with --frames and stats.####.json, those of each frame")
      ->type_name("FILE.json");
  add_keep_going(c, &a->keep_going);
  c->add_flag("--quiet", a->quiet, "Print errors and warnings only");
  c->footer(kExitCodes);
}

void add_inputs(CLI::App* c, std::string* file) {
  c->add_option(
       "--inputs", *file,
       "List of versions, colour configuration and files, as 'alabaster farm' writes it: refuse to begin where "
       "this machine has others")
      ->type_name("FILE");
}

CLI::App* add_render(CLI::App& app, RenderArguments* a) {
  CLI::App* c = app.add_subcommand(
      "render", "Renders a scene (glTF, a stage of OpenUSD or a render description .json) to files.");
  add_render_options(c, a);
  add_checkpoint(c, a);
  add_parsed(c, "--live", &a->live, parse_positive, "is not a number of seconds above 0.", "S",
             "Write the files every S seconds while they are rendered, marked incomplete, for viewers that read a file "
             "again when it changes: tev --watch frame.exr");
  add_inputs(c, &a->inputs);
  c->add_option("--running", a->running,
                "File that is there while the command runs, by which 'alabaster farm status' tells tasks that run from "
                "those that were killed")
      ->type_name("FILE");
  return c;
}

constexpr const char* kNotOfFarm[] = {"--skip-existing", "--pixel", "--stats"};

CLI::App* add_farm(CLI::App& app, FarmArguments* a) {
  CLI::App* c = app.add_subcommand(
      "farm",
      "Writes the jobs that render a frame on several machines, each a part of its samples, and merge the parts to the "
      "bytes of one machine's frame; with --frames each renders some frames. Takes the options of render; renders "
      "nothing itself.");
  add_render_options(c, &a->render);
  add_parsed(c, "--tasks", &a->tasks, parse_tasks, "is not a whole number from 1 to 10000.", "N",
             "Number of tasks: parts of the frame, or ranges of --frames; default with --frames: one for each frame");
  // The command refuses them with a reason, so it does not list them.
  for (const char* refused : kNotOfFarm) c->get_option(refused)->group("");
  c->add_option(
       "--engine", a->engine,
       "slurm: a job array and its merge; openjd: the same as a template of Open Job Description, which AWS Deadline "
       "Cloud reads; script: a command line for each task, for any other engine. Default: script")
      ->type_name("NAME");
  c->add_option("--folder", a->folder,
                "Folder for the jobs and the parts, which all machines must see; default: SCENE_farm")
      ->type_name("DIR");
  c->add_flag("--force", a->force, "Replace the jobs of an earlier farm in the folder, with their parts");
  CLI::App* status = c->add_subcommand(
      "status", "Tells of each task of a farm if it is done, runs, failed and why, its noise and its time.");
  status->add_option("folder", a->status.folder, "Folder of the jobs")->required()->type_name("FOLDER");
  status->add_flag("--json", a->status.json, "Print one JSON document instead of text");
  // CLI11 takes a required argument before it looks for a command.
  c->get_option("file")->required(false);
  c->callback([c, status] {
    if (c->count("file") == 0 && !status->parsed()) throw CLI::RequiredError("file");
  });
  status->footer(
      "Exit codes: 0 all tasks are done, 1 some run or have not begun, 2 bad usage, 3 the folder holds no farm, 4 a "
      "task "
      "failed or was killed, 6 done with --keep-going without all that the scene names.");
  return c;
}

CLI::App* add_merge(CLI::App& app, MergeArguments* a) {
  CLI::App* c = app.add_subcommand("merge",
                                   "Adds up the checkpoints of parts of a frame's samples; without -o, tells how far "
                                   "they are. The files are those of one render of all of them: "
                                   "denoised, too, if the parts were rendered with --denoise.");
  c->add_option("parts", a->parts, "Checkpoints of 'alabaster render --samples A:B', in any order")
      ->required()
      ->type_name("PART...");
  add_picture_options(c, a, "Extra layer for every .exr, which the parts must have; may be repeated");
  c->add_option("--ocio", a->ocio, "OpenColorIO config; default: $OCIO, else the built-in one")->type_name("FILE");
  add_inputs(c, &a->inputs);
  c->add_flag("--quiet", a->quiet, "Print errors and warnings only");
  c->footer(kExitCodes);
  return c;
}

CLI::App* add_tradeoff(CLI::App& app, TradeoffArguments* a) {
  CLI::App* c = app.add_subcommand(
      "tradeoff",
      "Measures speed against accuracy on a scene: noise and bias of every subsurface mode and quality setting.");
  add_scene_file(c, a);
  c->add_option("-o,--output", a->folder,
                "Folder for tradeoff.csv, .json, .md, .svg, .png and the state to resume from; default: SCENE_tradeoff")
      ->type_name("DIR");
  add_parsed(c, "--budget", &a->budget, parse_minutes,
             "is not a time: write a number of minutes above 0 and up to 10080 (a week), for example 10.", "MINUTES",
             "Rendering time, including earlier runs in the same folder; default: 10");
  add_size(c, &a->size, "Resolution in pixels; default: the scene's, reduced if the budget requires it");
  c->add_option("--only", a->only,
                "Measure only walk and the configurations whose names match; '^quality=' selects the presets")
      ->type_name("REGEX");
  c->add_flag("--denoise", a->denoise, "Measure each picture denoised, too (Open Image Denoise 2, if installed)");
  c->add_flag("--restart", a->restart, "Discard an earlier study in the folder and start afresh");
  c->add_flag("--quiet", a->quiet, "Print errors and warnings only");
  c->footer(kExitCodes);
  return c;
}

CLI::App* add_compare(CLI::App& app, CompareArguments* a) {
  CLI::App* c = app.add_subcommand(
      "compare",
      "Renders variants of a scene, and joins them in one picture: a sheet with the name, the noise and the time of "
      "each. Camera, display and exposure are the same for all.");
  RenderArguments* r = &a->render;
  add_scene_options(c, r);
  add_repeated(c, "--look", &a->looks, "'NAME: KEY=VALUE; KEY=VALUE'",
               "A variant: its name, and values as --set takes them, after those of --set. 'NAME:' is the scene as it "
               "is. To be repeated, once for each");
  c->add_option("-o,--output", a->output, "Sheet to write: .png")->required()->type_name("FILE");
  add_display(c, r);
  add_shutter(c, r);
  add_size(c, &r->size, "Size of each picture; default: the scene's, at most 480 pixels wide and high");
  add_setting_flags(c, r);
  c->add_flag("--denoise", r->denoise, "Show the pictures denoised; their noise is that before");
  c->add_flag("--quiet", r->quiet, "Print errors and warnings only");
  c->footer(kExitCodes);
  return c;
}

/// The options that were given, but those of `left_out`: a word each, so that no value passes for an option.
std::vector<std::string> given_options(const CLI::App* c, const std::set<std::string>& left_out) {
  std::vector<std::string> words;
  for (const CLI::Option* option : c->get_options()) {
    if (option->count() == 0 || option->get_positional() || left_out.contains(option_name(*option))) continue;
    if (option->get_expected_max() == 0) words.push_back(option_name(*option));
    if (option->get_expected_max() > 0)
      for (const std::string& value : option->results()) words.push_back(option_name(*option) + "=" + value);
  }
  return words;
}

// A task that is a part renders without outputs, and the merge needs only what makes files of pixels.
void split_options(const CLI::App* c, FarmArguments* a) {
  const std::set<std::string> of_files{"--output",   "--display",     "--view", "--look",
                                       "--exposure", "--compression", "--tiles"};
  std::set<std::string> not_of_task{"--tasks", "--engine", "--folder", "--force", "--quiet", "--frames"}, not_of_merge;
  if (!a->render.has_frames()) {
    not_of_task.insert(of_files.begin(), of_files.end());
    not_of_task.insert("--spp");
  }
  for (const CLI::Option* option : c->get_options())
    if (const std::string name = option_name(*option); !of_files.contains(name) && name != "--aov" && name != "--ocio")
      not_of_merge.insert(name);
  a->task_options = given_options(c, not_of_task);
  a->merge_options = given_options(c, not_of_merge);
}

/// An argument that a script left empty. Taken as not given, it would silently mean the default.
std::string empty_argument(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word.empty())
      return i > 1 && argv[i - 1][0] == '-' ? "the value of " + std::string(argv[i - 1]) + " is empty"
                                            : "argument " + std::to_string(i) + " is empty";
    if (word.starts_with("--") && word.find('=') + 1 == word.size()) return "the value of " + word + " is empty";
  }
  return {};
}

CLI::App* add_check(CLI::App& app, CheckArguments* a) {
  CLI::App* c = app.add_subcommand(
      "check",
      "Checks a scene without rendering it: reads it and all files that it names, builds what would be rendered, and "
      "reports every fault that a render would. Writes nothing.");
  add_scene_file(c, a);
  add_ocio(c, a);
  add_parsed(c, "--time-limit", &a->time_limit, parse_positive, "is not a number of seconds above 0.", "S",
             "Give up after this many seconds; default: 60");
  c->add_option("--memory-limit", a->memory_limit, "Memory for the scene, as in render")->type_name("MIB");
  c->add_flag("--quiet", a->quiet, "Print errors and warnings only");
  c->footer(kExitCodes);
  return c;
}

// All that follows `view` belongs to the window's program, --help included.
void add_view(CLI::App& app) {
  app.add_subcommand("view",
                     "Opens a window on a scene: look around, pick, edit, light, compare, save. 'alabaster view "
                     "--help' lists its options.");
}

CLI::App* add_convert(CLI::App& app, ConvertArguments* a) {
  CLI::App* c = app.add_subcommand(
      "convert", "Writes a scene, as the options change it, to one file (.alab) that every command reads.");
  add_scene_options(c, a);
  c->add_option("-o,--output", a->output, "File to write: NAME.alab")->required()->type_name("FILE");
  add_size(c, &a->size, "Size of the frame, by which a scene without a camera is framed");
  c->add_flag("--embed", a->embed, "Store images in the file; else it names them by path and digest");
  return c;
}

CLI::App* add_info(CLI::App& app, InfoArguments* a) {
  CLI::App* c = app.add_subcommand(
      "info",
      "Lists what a scene contains and what rendering it requires. Takes the options of render for one frame; nothing "
      "is written.");
  add_frame_options(c, &a->render);
  add_parsed(c, "--predict", &a->predict, parse_target_error,
             "is not a target error: write a relative RMSE above 0 and at most 1, for example 0.02.", "E",
             "Predict the cost of render with these options and --target-error E (0.02 is two per cent), from a probe "
             "of a few seconds");
  c->add_flag("--json", a->json, "Print one JSON document instead of text");
  return c;
}

CLI::App* add_usd(CLI::App& app, UsdArguments* a) {
  CLI::App* c =
      app.add_subcommand("usd", "Installs OpenUSD for Python, with which stages (.usd, .usda, .usdc, .usdz) are read.");
  c->add_option("action", a->action, "install")->required()->type_name("install");
  c->add_option("--from", a->from, "Folder with the wheels of usd-core and MaterialX, in the place of PyPI")
      ->type_name("FOLDER");
  return c;
}

/// usdrecord's flags of several letters behind one dash, which CLI11 does not have.
const char* long_flag(const std::string& word) {
  constexpr const char* kFlags[][2] = {{"-cam", "--camera"},
                                       {"-color", "--colorCorrectionMode"},
                                       {"-rp", "--renderPassPrimPath"},
                                       {"-rs", "--renderSettingsPrimPath"}};
  for (const auto& [given, flag] : kFlags)
    if (word == given) return flag;
  return nullptr;
}

CLI::App* add_usdrecord(CLI::App& app, UsdrecordArguments* u) {
  CLI::App* c = app.add_subcommand(
      "usdrecord", "Renders a stage by the options, lines and defaults of OpenUSD's program usdrecord.");
  RenderArguments* a = &u->render;
  hd::host::StageOptions* stage = &a->stage;
  c->add_option("usdFilePath", a->scene, "Stage to record")->required()->type_name("STAGE");
  c->add_option("outputImagePath", u->output,
                "File to write, with ### or ###.### for the time codes of --frames. Where the settings of the stage "
                "have products, these are written in its place")
      ->required()
      ->type_name("FILE");
  c->add_option("--mask", u->mask, "Prims to read, with those above and below them; between commas or spaces")
      ->type_name("PATH,...");
  c->add_option("--purposes", u->purposes, "Purposes to draw besides default; default: proxy")->type_name("LIST");
  c->add_option("--sessionLayer", stage->session_layer, "Layer over the stage")->type_name("FILE");
  c->add_option(
       "--camera", u->camera,
       "Camera, by name or path (-cam). Default: that of the settings, else main_cam; without one the stage is "
       "framed")
      ->type_name("NAME");
  c->add_flag("-d,--defaultTime", u->default_time, "The stage's default values; default: its start");
  add_parsed(c, "-f,--frames", &a->frames, parse_frames, kNoFrames, "SPEC,...",
             "Time codes: 101, 101:105, 105:101, 101:109x2, 101:104x0.5");
  add_parsed(c, "-c,--complexity", &a->complexity, parse_complexity, "is not low, medium, high or veryhigh.", "LEVEL",
             "low (the default: subdivision surfaces are not refined), medium, high or veryhigh");
  c->add_option("--colorCorrectionMode", u->color_correction,
                "sRGB (the default), openColorIO (the display of --ocio) or disabled, for .png, .tif and .jpg (-color)")
      ->check(CLI::IsMember({"disabled", "sRGB", "openColorIO"}))
      ->type_name("MODE");
  c->add_option("-r,--renderer", u->renderer, "Alabaster, whatever is asked")->type_name("NAME");
  c->add_option("-w,--imageWidth", u->width, "Width in pixels, 960 by default; the height is that of the camera's film")
      ->type_name("N");
  c->add_flag("--enableDomeLightVisibility", u->shows_domes, "The camera sees domes");
  c->add_option("--renderPassPrimPath", stage->pass, "RenderPass prim (-rp)")->type_name("PATH");
  c->add_option("--renderSettingsPrimPath", stage->settings,
                "RenderSettings prim (-rs); default: the one that the stage names")
      ->type_name("PATH");
  c->add_flag("--disableCameraLight", u->without_camera_light, "There is none in any case");
  for (const char* flag : {"--disableGpu", "--disableDrawMode", "--memstats"})
    c->add_flag(flag)->description("No effect");
  for (const char* flag : {"--resolver", "--traceToFile", "--traceFormat"})
    c->add_option(flag, "No effect")->type_name("WORD")->expected(1);
  add_setting_flags(c, a);
  add_repeated(c, "--set", &a->overrides, "KEY=VALUE", "Override a value, as in render");
  c->add_option("--variant", a->variant, "/PRIM{SET=CHOICE}, several one after the other")->type_name("NAME");
  add_repeated(c, "--aov", &a->aovs, "NAME[=LAYER]", "Extra layer for .exr, as in render");
  add_ocio(c, a);
  c->add_flag("--denoise", a->denoise, "Denoise the picture, as in render");
  c->add_option("--stats", a->stats, "Write the render's statistics as JSON")->type_name("FILE.json");
  add_stage_reading(c, a);
  add_keep_going(c, &a->keep_going);
  c->add_flag("--quiet", a->quiet, "Print errors and warnings only, and usdrecord's lines");
  c->footer(kExitCodes);
  return c;
}

CLI::App* add_schema(CLI::App& app, SchemaArguments* a) {
  CLI::App* c = app.add_subcommand("schema", "Prints a JSON schema, which lists every parameter.");
  c->add_option("name", a->name,
                "disney_material, texture_node, displacement_node, textures, mesh, lights, camera, render_settings, "
                "render_description or quality_presets")
      ->type_name("NAME");
  c->add_option("--write", a->folder,
                "Write the schemas, pages of the manual and stubs that are made from the tables of parameters, for "
                "developers: the folder is that of the sources")
      ->type_name("FOLDER");
  return c;
}

CLI::App* add_ocio(CLI::App& app, OcioArguments* a) {
  CLI::App* c = app.add_subcommand("ocio", "Lists colour spaces, displays, views and looks.");
  c->add_option("--ocio", a->ocio, "OpenColorIO config")->type_name("FILE");
  c->add_flag("--export", a->write_config, "Print the config itself, to keep or edit");
  return c;
}

CLI::App* add_completion(CLI::App& app, std::string* shell) {
  CLI::App* c = app.add_subcommand("completion", "Prints a script that completes commands and flags in a shell.");
  c->add_option("shell", *shell, "bash, zsh or fish")->required()->type_name("SHELL");
  return c;
}

struct Arguments {
  RenderArguments render;
  InfoArguments info;
  CompareArguments compare;
  CheckArguments check;
  ConvertArguments convert;
  OcioArguments ocio;
  UsdArguments usd;
  UsdrecordArguments usdrecord;
  TradeoffArguments tradeoff;
  MergeArguments merge;
  FarmArguments farm;
  SchemaArguments schema;
  std::string shell;
};

CLI::App* add_man(CLI::App& app, Arguments*) {
  return app.add_subcommand("man", "Prints the man page: every command and flag, as roff for 'man -l'.");
}

/// Runs a command. Where it ends by bad usage, the choice that an option does not have may be why.
int run_command(const CLI::App& app, const Words& words, const std::function<int()>& command) {
  try {
    return command();
  } catch (const Exit& exit) {
    const std::string right = exit.code == kUsage ? with_near_choices(app, words) : std::string();
    if (!right.empty()) Console(false).note("The command with the nearest choice:\n  " + right);
    throw;
  }
}

int parse_and_run(int argc, char** argv) {
  CLI::App app("Alabaster, a path tracer for translucent materials.", "alabaster");
  app.set_version_flag("--version", std::string(AlabasterVersions()));
  app.require_subcommand(1);
  app.footer(kExitCodes);
  std::vector<std::pair<const CLI::App*, std::function<int()>>> commands;
  const auto add = [&](auto&& add_command, auto* arguments, auto&& runs) {
    const CLI::App* command = add_command(app, arguments);
    commands.emplace_back(command, [arguments, runs] { return runs(*arguments); });
    return command;
  };
  Arguments a;
  const Words words(argv + 1, argv + argc);
  add(add_render, &a.render, run_render);
  add(add_merge, &a.merge, run_merge);
  const CLI::App* farm_command = add(add_farm, &a.farm, run_farm);
  const CLI::App* tradeoff_command = add(add_tradeoff, &a.tradeoff, run_tradeoff);
  add(add_compare, &a.compare, run_compare);
  add(add_info, &a.info, run_info);
  add(add_check, &a.check, run_check);
  add(add_convert, &a.convert, run_convert);
  add_view(app);
  add(add_usd, &a.usd, run_usd);
  add(add_usdrecord, &a.usdrecord, run_usdrecord);
  add(add_schema, &a.schema, run_schema);
  add(add_ocio, &a.ocio, run_ocio);
  add(add_completion, &a.shell, [&app](const std::string& shell) { return run_completion(app, shell); });
  add(add_man, &a, [&app](const Arguments&) { return run_man(app); });
  Words read(words.rbegin(), words.rend());  // as CLI11 wants them
  if (words[0] == "usdrecord")
    for (std::string& word : read)
      if (const char* const flag = long_flag(word.substr(0, word.find('='))))
        word = flag + word.substr(std::min(word.find('='), word.size()));
  try {
    app.parse(std::move(read));
  } catch (const CLI::ParseError& e) {
    return parse_fault(e, app, word_fault(app, words, e));
  }
  a.render.words = a.tradeoff.words = a.compare.render.words = words;
  if (farm_command->parsed()) split_options(farm_command, &a.farm);
  a.tradeoff.options = given_options(tradeoff_command, {"--restart", "--quiet"});
  for (const auto& [command, run_parsed] : commands)
    if (command->parsed()) return run_command(app, words, run_parsed);
  return kUsage;
}

int run(int argc, char** argv) {
  if (argc < 2) {
    std::fputs(examples_text().c_str(), stderr);
    return kUsage;
  }
  if (const std::string fault = empty_argument(argc, argv); !fault.empty())
    Console(false).usage_error("command line", fault + ": give a value, or leave it out.");
  return std::string(argv[1]) == "view" ? run_view(argv + 1) : parse_and_run(argc, argv);
}

// Output counts as printed only once it has arrived: a disk may be full.
int flushed(int code) {
  std::cout.flush();
  const bool good = std::cout.good() && std::fflush(stdout) == 0 && std::ferror(stdout) == 0;
  if (good || code != kDone) return code;
  std::fputs("error: standard output could not be written; check the space on the disk\n", stderr);
  return kOutput;
}

// A descriptor that was closed would become that of a file of ours, which would then get the messages. Standard output
// stays one that cannot be written, so that lost output is an error.
void take_closed_descriptors() {
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (fcntl(descriptor, F_GETFD) < 0) open("/dev/null", descriptor == STDERR_FILENO ? O_WRONLY : O_RDONLY);
}

}  // namespace
}  // namespace alabaster::cli

int main(int argc, char** argv) {
  alabaster::cli::take_closed_descriptors();
  try {
    return alabaster::cli::flushed(alabaster::cli::run(argc, argv));
  } catch (const alabaster::cli::Exit& exit) {
    return alabaster::cli::flushed(exit.code);
  } catch (const std::bad_alloc&) {
    std::fputs("error: not enough memory\n", stderr);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "error: %s\n", e.what());
  }
  return alabaster::cli::kRender;
}
