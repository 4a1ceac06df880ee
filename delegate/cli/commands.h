// The program's commands. Each returns an exit code and reports through a Console.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "delegate/cli/command_words.h"
#include "delegate/cli/flags.h"
#include "delegate/cli/scene_options.h"

namespace alabaster::cli {

/// Samples per pixel at which a render to an error ends, unless --spp is given or a preset of --quality allows more.
inline constexpr int kMaxSamplesWithTargetError = 65536;

/// The files of pictures, and how they show them. Empty: not given.
struct PictureArguments {
  std::vector<std::string> outputs, aovs;
  std::string display, view, look, compression;
  std::string color_space;  // of `outputs` but .exr, in the place of a display
  std::optional<float> exposure;
  std::optional<uint32_t> tiles;  // pixels of a side; 0: scanlines
  bool denoise = false;
};

/// Empty: not given.
struct RenderArguments : SceneArguments, PictureArguments {
  std::vector<hd::description::Override> settings;  // of the flags that name a render setting
  FrameList frames;
  std::optional<double> fps, start_frame;
  std::optional<uint32_t> turntable;                 // frames of a turn
  std::optional<std::pair<double, double>> shutter;  // open and close, in frames
  std::optional<hd::Vec2i> size;
  std::optional<hd::Rect2i> crop;
  std::optional<PixelChoice> pixel;
  Words words;  // of the whole command line
  std::string stats;
  std::string inputs;                                    // file: a farm's list of what decides its picture
  std::string running;                                   // file: there while the command runs
  std::optional<std::pair<uint32_t, uint32_t>> samples;  // begin and end
  std::string checkpoint;                                // file
  std::optional<double> checkpoint_interval, live;       // seconds
  bool quiet = false, keep_going = false, resume = false, skip_existing = false, turntable_lights = false;

  bool has_frames() const { return turntable || !frames.numbers.empty(); }
};
int run_render(RenderArguments arguments);

/// As usdrecord has them.
struct UsdrecordArguments {
  RenderArguments render;
  std::string output, mask, purposes = "proxy", camera, renderer, color_correction = "sRGB";
  int width = 960;
  bool default_time = false, without_camera_light = false, shows_domes = false;
};
int run_usdrecord(UsdrecordArguments arguments);

struct InfoArguments {
  RenderArguments render;         // of one frame
  std::optional<double> predict;  // a relative RMSE
  bool json = false;
};
int run_info(InfoArguments arguments);

struct CheckArguments : SceneArguments {
  double time_limit = 60;    // seconds
  std::string memory_limit;  // MiB
  bool quiet = false;
};
int run_check(const CheckArguments& arguments);

struct ConvertArguments : SceneArguments {
  std::string output;
  std::optional<hd::Vec2i> size;
  bool embed = false;
};
int run_convert(const ConvertArguments& arguments);

struct FarmArguments {
  RenderArguments render;
  uint32_t tasks = 0;  // 0: one for each frame
  std::string engine = "script", folder;
  bool force = false;                                    // replaces the jobs of the folder
  std::vector<std::string> task_options, merge_options;  // of each task and of the merge, a word each
  struct Status {
    std::string folder;  // empty: not asked
    bool json = false;
  } status;
};
/// Writes jobs, or tells how far those of a folder are.
int run_farm(const FarmArguments& arguments);
int run_farm_status(const FarmArguments::Status& arguments);

/// Without outputs, tells how far the parts are.
struct MergeArguments : PictureArguments {
  std::vector<std::string> parts;
  std::string ocio;
  std::string inputs;  // as of RenderArguments
  bool quiet = false;
};
int run_merge(const MergeArguments& arguments);

struct TradeoffArguments : SceneArguments {
  std::string folder;
  double budget = 10;  // minutes
  std::optional<hd::Vec2i> size;
  std::string only;  // regular expression
  Words words;       // of the whole command line
  Words options;     // that make the same study, such as --size=64x64
  bool denoise = false, restart = false, quiet = false;
};
int run_tradeoff(const TradeoffArguments& arguments);

struct CompareArguments {
  RenderArguments render;          // that all looks have
  std::vector<std::string> looks;  // "NAME: KEY=VALUE; KEY=VALUE"
  std::string output;
};
int run_compare(CompareArguments arguments);

/// Runs the program alabaster-view beside this one in its place. `arguments` begin with the name of the program and end
/// with null. Returns only if that fails, with the exit code.
int run_view(char** arguments);
/// The file alabaster-view beside this program; empty if there is none.
std::string view_program();

struct UsdArguments {
  std::string action, from;  // from: a folder with wheels
};
int run_usd(const UsdArguments& arguments);

struct SchemaArguments {
  std::string name, folder;
};
int run_schema(const SchemaArguments& arguments);

struct OcioArguments {
  std::string ocio;
  bool write_config = false;  // the whole config instead of a list
};
int run_ocio(const OcioArguments& arguments);

// Both print to standard output and return an exit code.
/// A page of section 1 in roff, with a section for each command of `app`.
int run_man(const CLI::App& app);
/// A script for `shell`, which is bash, zsh or fish: it completes commands, flags and files.
int run_completion(const CLI::App& app, const std::string& shell);

}  // namespace alabaster::cli
