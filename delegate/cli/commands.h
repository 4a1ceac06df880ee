// The program's commands. Each returns an exit code and reports through a Console.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "delegate/cli/scene_options.h"

namespace alabaster::cli {

/// Samples per pixel at which a render to an error ends, unless --spp is given or a preset of --quality allows more.
inline constexpr int kMostSamplesToAnError = 65536;

/// Arguments as given; empty if not given.
struct RenderArguments : SceneArguments {
  std::vector<std::string> outputs;
  std::string frames;   // "1:100" or "1:100:10"
  std::string fps;      // frames per second
  std::string shutter;  // "open:close", frames
  std::string size;     // "1280x720"
  std::string crop;     // "x0,y0,x1,y1"
  std::string pixel;    // "x,y" or "x,y,sample"
  std::string words;    // all arguments as typed, quoted for a shell, each after a space
  std::string quality;
  std::map<std::string, std::string> settings;  // of the flags that name a render setting, by its name
  std::string display, view, look;
  std::optional<float> exposure;
  std::vector<std::string> aovs;
  std::string stats;
  std::string samples;              // "256:512"
  std::string checkpoint;           // file
  std::string checkpoint_interval;  // seconds
  bool denoise = false, quiet = false, keep_going = false, resume = false;
};
int run_render(const RenderArguments& arguments);

/// Arguments as given; empty if not given.
struct InfoArguments {
  std::string scene;
  std::vector<std::string> overrides;
  std::string predict, size, threads;
  bool allow_outside = false;
};
int run_info(const InfoArguments& arguments);

struct CheckArguments {
  std::string scene;
  std::vector<std::string> overrides;
  std::string time_limit, memory_limit;  // seconds, MiB
  bool allow_outside = false, quiet = false;
};
int run_check(const CheckArguments& arguments);

struct ConvertArguments : SceneArguments {
  std::string output, size;
  bool embed = false;
};
int run_convert(const ConvertArguments& arguments);

struct FarmArguments {
  RenderArguments render;
  std::string tasks, engine = "script", folder;
  std::vector<std::string> task_options, merge_options;  // of each task and of the merge, a word each
};
int run_farm(const FarmArguments& arguments);

/// Without outputs, tells how far the parts are.
struct MergeArguments {
  std::vector<std::string> parts, outputs;
  std::string display, view, look, ocio;
  std::optional<float> exposure;
  std::vector<std::string> aovs;
  bool quiet = false;
};
int run_merge(const MergeArguments& arguments);

struct TradeoffArguments {
  std::string scene, folder;
  std::string budget;  // minutes
  std::string size;    // "320x180"
  std::string only;    // regular expression
  std::vector<std::string> overrides;
  bool denoise = false, restart = false, quiet = false, allow_outside = false;
};
int run_tradeoff(const TradeoffArguments& arguments);

/// Runs the program alabaster-view beside this one in its place. `arguments` begin with the name of the program and end
/// with null. Returns only if that fails, with the exit code.
int run_view(char** arguments);

struct SchemaArguments {
  std::string name, folder;
};
int run_schema(const SchemaArguments& arguments);

struct OcioArguments {
  std::string ocio;
  bool write_config = false;  // the whole config instead of a list
};
int run_ocio(const OcioArguments& arguments);

}  // namespace alabaster::cli
