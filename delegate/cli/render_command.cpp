#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "core/files/real_path.h"
#include "delegate/cli/exit_codes.h"
#include "delegate/cli/interrupt.h"
#include "delegate/cli/outputs.h"
#include "delegate/cli/picture_inputs.h"
#include "delegate/cli/render_messages.h"
#include "delegate/cli/render_options.h"
#include "delegate/cli/running_mark.h"
#include "delegate/cli/stats_file.h"
#include "delegate/cli/stopwatch.h"
#include "delegate/cli/turntable.h"
#include "delegate/support/output_file.h"
#include "delegate/support/size_text.h"

namespace alabaster::cli {
namespace {

using hd::host::RecordResult;

/// OpenEXR's attributes of a frame of a sequence: the rate, and where a time code can count it, the frame in hours,
/// minutes, seconds and frames.
hd::Dictionary sequence_metadata(double frame, double fps) {
  if (!(fps >= 0.001 && fps <= 1e6)) return {};  // beyond a ratio of whole numbers
  const double ntsc = std::round(fps * 1.001);
  const bool is_ntsc = std::abs(fps - ntsc / 1.001) < 1e-3 && fps != std::floor(fps);
  const hd::Vec2i rate = is_ntsc                  ? hd::Vec2i(int(ntsc) * 1000, 1001)
                         : fps == std::floor(fps) ? hd::Vec2i(int(fps), 1)
                                                  : hd::Vec2i(int(std::lround(fps * 1000)), 1000);
  hd::Dictionary all{{"framesPerSecond", rate}};
  constexpr double kMostFrames = 30, kDay = 24 * 3600;  // a time code's digits hold no more
  if (frame < 0 || frame != std::floor(frame) || fps != std::floor(fps) || fps > kMostFrames || frame >= kDay * fps)
    return all;
  const auto number = static_cast<uint32_t>(frame), per_second = static_cast<uint32_t>(fps);
  const uint32_t seconds = number / per_second;
  uint32_t packed = 0;
  for (const uint32_t part : {seconds / 3600, seconds / 60 % 60, seconds % 60, number % per_second})
    packed = packed << 8 | part / 10 << 4 | part % 10;  // SMPTE 12M, without dropped frames
  all["timeCode"] = hd::Vec2i(int(packed), 0);
  return all;
}

class RenderCommand {
 public:
  explicit RenderCommand(RenderArguments arguments) : a_(std::move(arguments)), console_(a_.quiet) {}

  int run() {
    catch_interrupts();
    check_combinations();
    check_outputs();
    if (!a_.running.empty()) console_.require(kOutput, a_.running, mark_.begin(a_.running));
    try {
      load();
      if (a_.stage.recorded_width) begin_record();
      require_inputs(a_.inputs, session_, a_.scene, &console_);
      if (!a_.pixel) set_products();
      session_.start(console_.sink());
    } catch (const Exit& end) {
      // A command line's fault may be the name of this file; but tasks of a farm have names of their own.
      const bool has_own_names = end.code != kUsage || !a_.running.empty();
      if (has_own_names && may_be_statistics(stats_file())) write_stats(stats_, stats_file(), end.code);
      throw;
    }
    if (a_.pixel) return trace_pixel();
    const int code = render();
    if (!has_stats_of_frames()) write_stats(stats_, a_.stats, code);
    if (code == kDone || code == kDegraded) messages_.summarize(stats_, code == kDegraded);
    // A degraded part ends with 0, so that a farm does not repeat it. The merge ends with 6.
    return code == kDegraded && a_.samples ? kDone : code;
  }

 private:
  // Flags that need others, or exclude them.
  void check_combinations() {
    const bool frames = !a_.frames.numbers.empty(), no_checkpoint = a_.checkpoint.empty();
    const auto is_spp = [](const hd::description::Override& one) { return one.place == "samples"; };
    const bool spp = std::any_of(a_.settings.begin(), a_.settings.end(), is_spp);
    std::vector<double> sorted = a_.frames.numbers;
    std::sort(sorted.begin(), sorted.end());
    const bool twice = std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end();
    const struct {
      bool is_wrong;
      const char *flag, *text;
    } combinations[] = {
        {a_.fps && !frames && !a_.shutter, "--fps", "It needs --frames or --shutter."},
        {a_.turntable && a_.pixel, "--turntable", "It cannot be given with --pixel, which shows one frame."},
        {frames && !a_.turntable && (a_.time || a_.pixel), "--frames",
         "It cannot be given with --time or --pixel, which show one frame."},
        {twice, "--frames", "It names a frame twice."},
        {a_.start_frame && !frames, "--start-frame", "It needs --frames."},
        {a_.start_frame && a_.turntable, "--start-frame", "It cannot be given with --turntable."},
        {a_.turntable_lights && !a_.turntable, "--turntable-lights", "It needs --turntable."},
        {a_.skip_existing && !frames, "--skip-existing", "It needs --frames."},
        {a_.skip_existing && a_.samples, "--skip-existing",
         "It cannot be given with --samples, which writes no files of frames."},
        {a_.samples && spp, "--samples", "It cannot be given with --spp: its end says how many samples there are."},
        {a_.pixel && !no_checkpoint, "--checkpoint", "It cannot be given with --pixel."},
        {a_.resume && no_checkpoint, "--resume", "It needs --checkpoint FILE."},
        {a_.samples && no_checkpoint, "--samples", "It needs --checkpoint FILE."},
        {a_.live && a_.pixel, "--live", "It cannot be given with --pixel, which writes no files."},
        {a_.live && a_.samples && a_.outputs.empty(), "--live", "It needs -o FILE, which shows the part."},
        {a_.checkpoint_interval && no_checkpoint, "--checkpoint-interval", "It needs --checkpoint FILE."}};
    for (const auto& [is_wrong, flag, text] : combinations)
      if (is_wrong) console_.usage_error(flag, text);
  }

  // Checks the flags about files before the scene is read. Whether products can be written is planned with its frames.
  void check_outputs() {
    // The products of a stage come before usdrecord's file.
    if (!a_.frames.numbers.empty() && !a_.stage.recorded_width) check_frame_names(a_.outputs, a_, console_);
    if (has_stats_of_frames()) check_frame_names({a_.stats}, a_, console_);
    check_checkpoint_files(a_, console_);
    std::vector<std::string> files = a_.outputs;
    if (!a_.stats.empty()) files.push_back(a_.stats);
    if (!a_.checkpoint.empty()) files.push_back(a_.checkpoint);
    if (!a_.running.empty()) files.push_back(a_.running);
    console_.require_usage("render", same_file_twice(files));
    if (!a_.stats.empty()) console_.require(kOutput, stats_file(), hd::support::OutputFault(stats_file()));
    if (!a_.outputs.empty()) products_ = make_products(a_, {}, "render", console_);
  }

  template <class Work>
  void timed_load(const Work& work) {
    const Stopwatch watch;
    work();
    for (RunStats* stats : {&stats_, &of_frame_stats_}) stats->add_load(watch.wall(), watch.cpu());
  }

  void load() {
    timed_load([&] { open_scene(a_, load_options(a_), console_, console_.sink(), &session_); });
    const auto is_stage = [](const auto& model) { return model.timeCodesPerSecond > 0; };
    if (const auto& models = session_.file.models;
        a_.start_frame && std::any_of(models.begin(), models.end(), is_stage))
      console_.usage_error("--start-frame", "The frames of a stage are its time codes: leave it out.");
  }

  // Products that the stage's settings name are written in the place of the file that usdrecord is given.
  void begin_record() {
    const hd::Path camera = session_.scene.GetRenderSettings(session_.file.settings).camera;
    std::printf("Camera: %s\nRenderer plugin: HdAlabasterRendererPlugin\n",
                session_.file.framed ? "" : printable(camera.str()).c_str());
    if (!session_.scene.GetRenderSettings(session_.file.settings).products.empty())
      a_.outputs.clear(), products_.clear();
    const auto& range = session_.file.info.range;
    if (a_.frames.numbers.empty()) say_time_code(a_.stage.at_default_time ? NAN : range ? (*range)[0] : 0);
  }

  void say_time_code(double code) const {
    if (!a_.stage.recorded_width) return;
    std::printf("Recording time code: %f\n", code);
    std::fflush(stdout);
  }

  std::vector<hd::Path> settings_paths() const {
    std::vector<hd::Path> paths{session_.file.settings};
    if (a_.outputs.empty())
      paths.insert(paths.end(), session_.file.further_settings.begin(), session_.file.further_settings.end());
    return paths;
  }

  // Gives every render its products.
  void set_products() {
    check_parts(a_, session_, settings_paths().size(), console_);
    if (a_.samples && a_.outputs.empty()) {
      part_aovs_ = take_part_aovs(a_, &session_, &of_frame_);
      return check_names({});
    }
    if (!a_.outputs.empty())
      for (const hd::Path& path : session_.file.further_settings) session_.scene.Remove(path);
    const auto all = session_.scene.GetAllRenderSettings();
    std::vector<hd::RenderProduct> described;
    for (const hd::Path& path : settings_paths())
      described.insert(described.end(), all.at(path).products.begin(), all.at(path).products.end());
    if (a_.outputs.empty() && described.empty()) refuse_without_output();
    if (a_.outputs.empty()) products_ = make_products(a_, described, "render", console_);
    check_names(products_);
    auto next = products_.begin();
    for (const hd::Path& path : settings_paths()) {
      hd::RenderSettingsDescription settings = all.at(path);
      const auto end = a_.outputs.empty() ? next + std::ptrdiff_t(settings.products.size()) : products_.end();
      settings.products.assign(next, end);
      next = end;
      session_.scene.SetRenderSettings(path, std::move(settings));
    }
  }

  [[noreturn]] void refuse_without_output() {
    const std::string picture = std::filesystem::path(a_.scene).stem().string() + ".png";
    const std::string command = command_text(with_options(a_.words, {}, {"-o", picture}));
    console_.usage_error("render", "There is nothing to write: add -o FILE, or products to the render description." +
                                       (command.empty() ? command : "\n  " + command));
  }

  // Checks the description's file names, and --stats against them. Names given with -o have been checked before.
  void check_names(const std::vector<hd::RenderProduct>& products) {
    std::vector<std::string> files;
    for (const hd::RenderProduct& product : products) files.push_back(product.file);
    if (!a_.frames.numbers.empty()) {
      check_frame_names(files, a_, console_);
      files.clear();
      for (const double frame : a_.frames.numbers)
        for (const hd::RenderProduct& product : products) {
          files.push_back(frame_file(product.file, frame));
          // A description's file lies in its folder once it has its number, too. Its writer judges that again.
          if (!product.within.empty())
            console_.require(kInput, files.back(), outside_fault(product.within, files.back()));
        }
    }
    console_.require(kInput, a_.scene, same_file_twice(files));
    if (a_.outputs.empty()) console_.require(kInput, a_.scene, input_overwritten(files, session_, a_.scene));
    if (has_stats_of_frames())
      for (const double frame : a_.frames.numbers) files.push_back(frame_file(a_.stats, frame));
    else if (!a_.stats.empty())
      files.push_back(a_.stats);
    if (!a_.running.empty()) files.push_back(a_.running);
    const std::vector<std::string> checkpoints = checkpoint_files(a_);
    files.insert(files.end(), checkpoints.begin(), checkpoints.end());
    console_.require_usage("render", input_overwritten(files, session_, a_.scene));
    console_.require_usage("--stats", same_file_twice(files));
  }

  int render() {
    const bool is_alone = a_.frames.numbers.empty();
    const int code = is_alone ? render_frame(frame_number(session_.scene.GetRenderSettings(session_.file.settings)))
                              : render_frames();
    if (code == kInterrupted) {
      for (const std::string& file : written_)
        console_.note((is_alone ? "interrupted: wrote the picture so far to " : "interrupted: wrote ") + file);
      if (written_.empty()) console_.note("interrupted: nothing was written");
      if (!a_.checkpoint.empty()) console_.note("the same command with --resume continues from the checkpoint");
    }
    return code;
  }

  // Ends at the first frame that fails or is interrupted; those before it are done.
  int render_frames() {
    const auto all = session_.scene.GetAllRenderSettings();
    const std::map<hd::Path, hd::RenderSettingsDescription> described(all.begin(), all.end());
    const std::vector<double>& frames = a_.frames.numbers;
    const double start = a_.start_frame.value_or(0), codes = session_.file.info.timeCodesPerSecond;
    std::optional<Turntable> turntable;
    if (a_.turntable) turntable.emplace(&session_, a_.turntable_lights);
    if (!a_.turntable && codes == 0) warn_of_frames_after_the_animation();
    const Stopwatch watch;
    size_t rendered = 0;
    int code = kDone;
    for (size_t i = 0; i < frames.size(); ++i) {
      if (interrupted()) return kInterrupted;
      const double frame = frames[i];
      if (i > 0) of_frame_stats_ = {};
      for (const hd::Path& path : settings_paths()) {
        hd::RenderSettingsDescription settings = described.at(path);
        settings.frame = std::floor(std::abs(frame));  // of its noise
        for (hd::RenderProduct& product : settings.products) product.file = frame_file(product.file, frame);
        session_.scene.SetRenderSettings(path, std::move(settings));
      }
      if (a_.skip_existing && has_all_files()) {
        console_.note(formatted("frame %g is there (%zu of %zu)", frame, i + 1, frames.size()));
        if (has_stats_of_frames()) tell_done(frame_file(a_.stats, frame));
        continue;
      }
      const double fps = a_.fps.value_or(codes > 0 ? codes : 24);
      metadata_ = sequence_metadata(frame, fps);
      std::string place = formatted("at %.4g s", (frame - start) / fps);
      if (turntable) {
        const double step = 360.0 / *a_.turntable, degrees = 360 * (frame - 1) / *a_.turntable;
        turntable->turn(degrees, step);
        place = formatted("turned by %.4g degrees", degrees);
      } else if (i > 0) {
        try {
          timed_load([&] { session_.pose(frame - start, console_.sink()); });
        } catch (const Exit& end) {
          if (has_stats_of_frames()) write_stats(of_frame_stats_, frame_file(a_.stats, frame), end.code);
          return end.code;
        }
      }
      say_time_code(frame);
      console_.note(formatted("frame %g %s (%zu of %zu)", frame, place.c_str(), i + 1, frames.size()));
      const size_t before = written_.size();
      const int one = render_frame(frame);
      if (has_stats_of_frames()) write_stats(of_frame_stats_, frame_file(a_.stats, frame), one);
      if (one != kDone) code = one;
      if (one != kDone && one != kDegraded) break;
      messages_.end_frame(frame, i + 1, watch.wall() / double(++rendered),
                          {written_.begin() + std::ptrdiff_t(before), written_.end()});
    }
    return code;
  }

  void warn_of_frames_after_the_animation() {
    double last = 0;
    for (const auto& model : session_.file.models)
      for (const auto& animation : model.animations) last = std::max(last, animation.seconds);
    const std::vector<double>& frames = a_.frames.numbers;
    const double first = *std::min_element(frames.begin(), frames.end());
    const double begin = (first - a_.start_frame.value_or(0)) / a_.fps.value_or(24);
    if (last == 0 || begin <= last) return;
    console_.sink()({hd::Severity::warning, "render.time", a_.scene,
                     formatted("All frames lie after the last key of its animation, at %.4g s, and show the same; "
                               "--start-frame %g makes the first one its start.",
                               last, first)});
  }

  bool has_all_files() {
    for (const hd::Path& path : settings_paths()) {
      const hd::RenderSettingsDescription frame = session_.scene.GetRenderSettings(path);
      for (const hd::RenderProduct& product : frame.products)
        if (!is_there(frame, product)) return false;
    }
    return true;
  }

  bool has_stats_of_frames() const { return !a_.frames.numbers.empty() && frame_place(a_.stats); }
  /// The file for what comes before the first frame is rendered.
  std::string stats_file() const {
    return has_stats_of_frames() ? frame_file(a_.stats, a_.frames.numbers[0]) : a_.stats;
  }

  // All renders of the frame are planned before the first begins.
  int render_frame(double number) {
    // An invalid product is a fault of the command line or of the description.
    const bool named = !a_.outputs.empty() || !a_.display.empty() || !a_.view.empty() || !a_.look.empty() ||
                       !a_.compression.empty() || a_.tiles;
    std::vector<hd::host::RecordOptions> renders;
    for (const hd::Path& path : settings_paths()) {
      hd::host::RecordOptions& options = renders.emplace_back();
      options.colors = session_.colors();
      options.keep_going = a_.keep_going;
      options.faults = session_.faults();
      options.aovs = part_aovs_;
      options.of_frame = of_frame_;
      options.metadata = metadata_;
      set_checkpoint(a_, number, console_, &options);
      options.live_seconds = a_.live.value_or(0);
      options.cancel = &interrupted();
      options.drops_incomplete = !a_.frames.numbers.empty();
      options.diagnostics = console_.sink();
      options.writing = [] { set_writing(true); };
      options.plan = hd::host::PlanFrame(session_.scene, path, *session_.delegate(), options);
      if (const int refused = exit_code(options.plan, named); refused != kDone) return refused;
    }
    int code = kDone;
    auto options = renders.begin();
    for (const hd::Path& path : settings_paths()) {
      const hd::RenderSettingsDescription frame = session_.scene.GetRenderSettings(path);
      set_writing(false);
      options->progress = [&](const hd::host::RecordProgress& progress) {
        if (progress.fraction > 0) set_worth_saving(true);
        messages_.progress(frame, progress);
      };
      const RecordResult result = hd::host::RecordFrame(session_.index(), &session_.scene, path, *options++);
      console_.end_progress();
      for (RunStats* stats : {&stats_, &of_frame_stats_}) stats->add_render(frame, number, result);
      written_.insert(written_.end(), result.written.begin(), result.written.end());
      messages_.add(frame, result);
      const int one = exit_code(result);
      say_suspect(result.stats, one);
      if (one != kDone) code = one;
      if (one != kDone && one != kDegraded) break;
    }
    return code;
  }

  // Renders the pixel alone in each of the scene's frames that has it, and prints its paths.
  int trace_pixel() {
    const PixelChoice& pixel = *a_.pixel;
    const std::vector<hd::Path> paths = settings_paths();
    int code = kUsage;
    std::string sizes;
    for (const hd::Path& path : paths) {
      hd::RenderSettingsDescription settings = session_.scene.GetAllRenderSettings().at(path);
      const std::string size = hd::support::size_option(settings.width, settings.height);
      sizes += (sizes.empty() ? "" : " and of ") + size;
      const bool overscan = settings.window().contains(pixel.x, pixel.y);
      if (!overscan && !settings.frame_window().contains(pixel.x, pixel.y)) continue;
      if (paths.size() > 1)
        std::printf("frame of %s, for %s:\n", size.c_str(), printable(settings.products[0].file).c_str());
      code = trace_pixel(path, pixel, std::move(settings));
      if (code != kDone && code != kDegraded) return code;
    }
    if (code == kUsage)
      console_.usage_error("--pixel", "'" + std::to_string(pixel.x) + "," + std::to_string(pixel.y) +
                                          "' lies outside the frame of " + sizes + ".");
    return code;
  }

  int trace_pixel(const hd::Path& path, const PixelChoice& pixel, hd::RenderSettingsDescription settings) {
    // A crop must overlap the frame: a pixel of the overscan is rendered with those between.
    const int x = std::clamp(pixel.x, 0, settings.width - 1), y = std::clamp(pixel.y, 0, settings.height - 1);
    settings.crop =
        hd::Rect2i{std::min(x, pixel.x), std::min(y, pixel.y), std::max(x, pixel.x) + 1, std::max(y, pixel.y) + 1};
    settings.products.clear();
    session_.scene.SetRenderSettings(path, std::move(settings));
    hd::host::RecordOptions options;
    options.keep_going = a_.keep_going;
    options.cancel = &interrupted();
    options.diagnostics = console_.sink();
    const RecordResult result = hd::host::RecordFrame(session_.index(), &session_.scene, path, options);
    hd::Dictionary arguments{{"x", hd::Value(pixel.x)}, {"y", hd::Value(pixel.y)}};
    if (pixel.sample) arguments["sample"] = hd::Value(static_cast<int64_t>(*pixel.sample));
    const hd::CommandResult traced = session_.delegate()->InvokeCommand("tracePixel", arguments);
    const std::string text = traced.value.text_or("");
    std::fputs((text + prim_names(text)).c_str(), stdout);
    const int code = exit_code(result);
    if (traced.ok() || (code != kDone && code != kDegraded)) return code;
    console_.error("--pixel", traced.fault);
    return kRender;
  }

  // The paths of the prims whose ids a text names.
  std::string prim_names(const std::string& text) const {
    const std::string key = "primId ";
    std::map<int, std::string> names;
    for (size_t at = text.find(key); at != std::string::npos; at = text.find(key, at + 1)) {
      const int id = std::atoi(text.c_str() + at + key.size());
      names[id] = printable(session_.index()->GetRprimPathFromPrimId(id).str());
    }
    std::string legend;
    for (const auto& [id, name] : names) legend += key + std::to_string(id) + " is " + name + "\n";
    return legend;
  }

  // A sample that was not finite or failed a check is a fault of ours or of the scene; this command shows it again.
  void say_suspect(const hd::Dictionary& stats, int code) {
    const auto found = stats.find("suspectSample");
    if (found == stats.end()) return;
    const bool failed = code == kRender;
    const std::string what = failed ? "A sample failed a check or was not finite."
                                    : "A sample was not finite; the picture has black in its place.";
    const std::string pixel = found->second.text_or("");
    Words words = a_.words;
    words.insert(words.begin() + 1, {"--pixel", pixel});
    const std::string command = command_text(words);
    const std::string way = command.empty() ? "add to the command: --pixel " + pixel : "run:\n  " + command;
    console_.sink()(
        {failed ? hd::Severity::error : hd::Severity::warning, "render.sample", "", what + " To see its path, " + way});
  }

  static nlohmann::json statistics_in(const std::string& file) {
    std::ifstream in(file);
    nlohmann::json found = nlohmann::json::parse(in, nullptr, false);
    return found.contains("versions") && found.contains("phases") ? found : nlohmann::json();
  }

  /// The inputs of a scene that cannot be read are not known: a file of something else may be one.
  static bool may_be_statistics(const std::string& file) {
    return !std::filesystem::is_regular_file(file) || !statistics_in(file).is_null();
  }

  /// Of a frame that is there: its statistics may be those of an earlier failure, or may not have been written.
  void tell_done(const std::string& file) {
    const nlohmann::json found = statistics_in(file);
    const auto code = found.is_null() ? found.end() : found.find("exitCode");
    if (code == found.end() || (*code != kDone && *code != kDegraded)) write_stats({}, file, kDone);
  }

  void write_stats(const RunStats& stats, const std::string& file, int code) {
    if (file.empty()) return;
    hd::Dictionary settings;
    if (session_.delegate())
      for (const hd::RenderSettingDescriptor& descriptor : session_.delegate()->GetRenderSettingDescriptors())
        settings[descriptor.key.str()] = session_.delegate()->GetRenderSetting(descriptor.key);
    set_writing(true);
    try {
      console_.write_file(file,
                          stats.to_json(a_.scene, code, console_.last_error(), settings)
                                  .dump(2, ' ', false, nlohmann::json::error_handler_t::replace) +
                              "\n",
                          "The statistics", code == kInterrupted ? hd::support::Flush::none : hd::support::Flush::disk);
    } catch (const Exit&) {
      if (code == kDone || code == kDegraded) throw;  // else the command ends by what came before
    }
  }

  RenderArguments a_;
  Console console_;
  RunningMark mark_;
  SceneSession session_{!a_.frames.numbers.empty()};
  RenderMessages messages_{a_, session_, &console_};
  RunStats stats_, of_frame_stats_;  // of the run, and of the present frame of --frames
  std::vector<hd::RenderProduct> products_;
  std::vector<std::string> written_;
  std::vector<std::string> part_aovs_;  // of a part without files
  std::vector<hd::RenderProduct> of_frame_;
  hd::Dictionary metadata_;  // of the files of a frame of --frames
};

}  // namespace

int run_render(RenderArguments arguments) {
  if (arguments.turntable && arguments.frames.numbers.empty())
    for (uint32_t frame = 1; frame <= *arguments.turntable; ++frame) arguments.frames.numbers.push_back(frame);
  return RenderCommand(std::move(arguments)).run();
}

}  // namespace alabaster::cli
