#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/files/real_path.h"
#include "delegate/cli/checkpoint_options.h"
#include "delegate/cli/control_characters.h"
#include "delegate/cli/exit_codes.h"
#include "delegate/cli/interrupt.h"
#include "delegate/cli/outputs.h"
#include "delegate/cli/render_options.h"
#include "delegate/cli/stats_file.h"
#include "delegate/cli/stopwatch.h"
#include "delegate/description/quality_presets.h"
#include "delegate/host/product_limits.h"
#include "delegate/support/output_file.h"
#include "delegate/support/process_usage.h"

namespace alabaster::cli {
namespace {

using hd::host::RecordResult;
using hd::host::RecordStatus;

class RenderCommand {
 public:
  explicit RenderCommand(const RenderArguments& arguments) : a_(arguments), console_(arguments.quiet) {}

  int run() {
    catch_interrupts();
    int code = check_arguments();
    if (code == kDone) code = load();
    if (code == kDone && a_.pixel.empty()) code = plan_products();
    if (code != kDone) return code;
    if (!session_.start(console_.sink())) return kRender;
    if (!a_.pixel.empty()) return trace_pixel();
    code = render();
    const int stats_code = write_stats(code);
    if ((code == kDone || code == kDegraded) && stats_code != kDone) code = stats_code;
    if (code == kDone || code == kDegraded) summarize();
    return code;
  }

 private:
  // Refuses bad arguments before the scene is read.
  int check_arguments() {
    if (const int code = check_values(a_, console_); code != kDone) return code;
    if (!a_.pixel.empty() && !parse_pixel(a_.pixel))
      return console_.usage_error(
          "--pixel", "'" + a_.pixel + "' is not a pixel: write x,y or x,y,sample, for example 320,200 or 320,200,5.");
    if (const int code = check_times(); code != kDone) return code;
    if (const int code = check_checkpoint(a_, console_); code != kDone) return code;
    if (const int code = check_checkpoint_files(a_, console_); code != kDone) return code;
    std::vector<std::string> files = a_.outputs;
    if (!a_.stats.empty()) files.push_back(a_.stats);
    if (!a_.checkpoint.empty()) files.push_back(a_.checkpoint);
    if (const std::string problem = same_file_twice(files); !problem.empty())
      return console_.usage_error("render", problem);
    if (!a_.stats.empty())
      if (const std::string fault = hd::support::OutputFault(a_.stats); !fault.empty()) {
        console_.error(a_.stats, fault);
        return kOutput;
      }
    // -o can be checked without the scene; the files of a description are checked once it is loaded.
    if (a_.outputs.empty()) return kDone;
    std::string problem;
    const auto products = make_products(a_, {}, &problem);
    if (!problem.empty()) return console_.usage_error("render", problem);
    // The scene may name the OCIO config, so names of displays are checked once it is loaded.
    for (hd::RenderProduct product : products) {
      product.display = product.view = product.look = "";
      if (const auto check = hd::host::CheckProduct(product, {"built-in"}, console_.sink()); !check)
        return product_failure(check.status);
    }
    return kDone;
  }

  int check_times() {
    const bool uses_fps = !a_.frames.empty() || !a_.shutter.empty();
    if (!a_.fps.empty() && !uses_fps) return console_.usage_error("--fps", "It needs --frames or --shutter.");
    if (a_.frames.empty()) return kDone;
    if (parse_frames(a_.frames).empty())
      return console_.usage_error("--frames", "'" + a_.frames + "' is not a range of frames, at most 100000: write " +
                                                  "first:last or first:last:step, in whole numbers.");
    if (!a_.time.empty() || !a_.pixel.empty())
      return console_.usage_error("--frames", "It cannot be given with --time or --pixel, which show one frame.");
    return check_frame_names(a_.outputs);
  }

  int check_frame_names(const std::vector<std::string>& files) {
    for (const std::string& file : files)
      if (frame_file(file, 0).empty())
        return console_.usage_error("--frames", "All frames would go to '" + file +
                                                    "': give the name a place for their numbers, such as "
                                                    "frame.####.exr.");
    return kDone;
  }

  // An invalid product is a fault of the command line or of the description.
  int product_failure(hd::host::ProductStatus status) const {
    return exit_code(status, !a_.outputs.empty() || !a_.display.empty() || !a_.view.empty() || !a_.look.empty());
  }

  int load() {
    const Stopwatch watch;
    const hd::description::LoadOptions options = load_options(a_);
    const int code = load_scene(a_, options, console_, console_.sink(), &session_);
    stats_.add_load(watch.wall(), watch.cpu());
    return code;
  }

  int pose(double seconds) {
    const Stopwatch watch;
    const int code = session_.pose(seconds, console_.sink());
    stats_.add_load(watch.wall(), watch.cpu());
    return code;
  }

  std::vector<hd::Path> settings_paths() const {
    std::vector<hd::Path> paths{session_.file.settings};
    if (a_.outputs.empty())
      paths.insert(paths.end(), session_.file.further_settings.begin(), session_.file.further_settings.end());
    return paths;
  }

  // Gives every render its products, sizes and crops, and checks all files before anything is rendered.
  int plan_products() {
    if (const int code = check_parts(a_, session_, settings_paths().size(), console_); code != kDone) return code;
    if (!a_.samples.empty() && a_.outputs.empty()) {
      part_aovs_ = take_part_aovs(a_, &session_);
      return check_names({});
    }
    const auto all = session_.scene.GetAllRenderSettings();
    const hd::RenderSettingsDescription& first = all.at(session_.file.settings);
    if (!a_.outputs.empty())
      for (const hd::Path& path : session_.file.further_settings) session_.scene.Remove(path);
    std::vector<hd::RenderProduct> described;
    for (const hd::Path& path : settings_paths())
      described.insert(described.end(), all.at(path).products.begin(), all.at(path).products.end());
    std::string problem;
    const auto products = make_products(a_, described, &problem);
    if (!problem.empty()) return console_.usage_error("render", problem);
    if (const int code = check_names(products); code != kDone) return code;
    size_t next = 0;
    for (const hd::Path& path : settings_paths()) {
      hd::RenderSettingsDescription settings = a_.outputs.empty() ? all.at(path) : first;
      const size_t count = a_.outputs.empty() ? settings.products.size() : products.size();
      settings.products.assign(products.begin() + static_cast<std::ptrdiff_t>(next),
                               products.begin() + static_cast<std::ptrdiff_t>(next + count));
      next += count;
      override_size(&settings);
      if (!a_.crop.empty() && !settings.window().overlaps(settings.frame_window()))
        return console_.usage_error("--crop", "'" + a_.crop + "' lies wholly outside the frame of " +
                                                  std::to_string(settings.width) + "x" +
                                                  std::to_string(settings.height) + ".");
      for (const hd::RenderProduct& product : settings.products) {
        hd::host::ProductCheck check = hd::host::CheckProduct(product, session_.colors(), console_.sink());
        if (check) check = hd::host::CheckProductSize(product, settings.window(), console_.sink());
        if (!check) return product_failure(check.status);
      }
      session_.scene.SetRenderSettings(path, std::move(settings));
    }
    return kDone;
  }

  // A description's file lies in its folder once it has its number, too. Where it is written that is judged again.
  int check_place(const std::string& file, const std::string& within) {
    const std::string fault = within.empty() ? std::string() : outside_fault(within, file);
    if (!fault.empty()) console_.error(file, fault);
    return fault.empty() ? kDone : kInput;
  }

  // Checks the description's file names, and --stats against them. Names given with -o have been checked before.
  int check_names(const std::vector<hd::RenderProduct>& products) {
    std::vector<std::string> files;
    for (const hd::RenderProduct& product : products) files.push_back(product.file);
    if (!frames_.empty()) {
      if (const int code = check_frame_names(files); code != kDone) return code;
      files.clear();
      for (const uint32_t frame : frames_)
        for (const hd::RenderProduct& product : products) {
          files.push_back(frame_file(product.file, frame));
          if (const int code = check_place(files.back(), product.within); code != kDone) return code;
        }
    }
    std::string problem = same_file_twice(files);
    if (!problem.empty()) {
      console_.error(a_.scene, problem);
      return kInput;
    }
    if (a_.outputs.empty())
      if (problem = input_overwritten(files, session_, a_.scene); !problem.empty()) {
        console_.error(a_.scene, problem);
        return kInput;
      }
    if (!a_.stats.empty()) files.push_back(a_.stats);
    const std::vector<std::string> checkpoints = checkpoint_files(a_);
    files.insert(files.end(), checkpoints.begin(), checkpoints.end());
    problem = input_overwritten(files, session_, a_.scene);
    if (!problem.empty()) return console_.usage_error("render", problem);
    problem = same_file_twice(files);
    return problem.empty() ? kDone : console_.usage_error("--stats", problem);
  }

  // Applies --size and --crop to settings other than the first, which got them while loading. They override the
  // products'.
  void override_size(hd::RenderSettingsDescription* settings) const {
    if (const auto size = parse_size(a_.size)) {
      settings->width = size->x;
      settings->height = size->y;
    }
    if (const auto crop = parse_crop(a_.crop)) settings->crop = crop;
  }

  int render() {
    const int code = frames_.empty() ? render_frame() : render_frames();
    if (code == kInterrupted) {
      for (const std::string& file : written_)
        console_.note((frames_.empty() ? "interrupted: wrote the picture so far to " : "interrupted: wrote ") + file);
      if (written_.empty()) console_.note("interrupted: nothing was written");
      if (!a_.checkpoint.empty()) console_.note("the same command with --resume continues from the checkpoint");
    }
    return code;
  }

  // Ends at the first frame that fails or is interrupted; those before it are done.
  int render_frames() {
    const auto described = session_.scene.GetAllRenderSettings();
    int code = kDone;
    for (size_t i = 0; i < frames_.size(); ++i) {
      if (interrupted()) return kInterrupted;
      const uint32_t frame = frames_[i];
      const double seconds = seconds_at(a_, frame);
      if (const int posed = i > 0 ? pose(seconds) : kDone; posed != kDone) return posed;
      for (const hd::Path& path : settings_paths()) {
        hd::RenderSettingsDescription settings = described.at(path);
        settings.settings["frame"] = int64_t(frame);
        for (hd::RenderProduct& product : settings.products) product.file = frame_file(product.file, frame);
        session_.scene.SetRenderSettings(path, std::move(settings));
      }
      char text[120];
      std::snprintf(text, sizeof text, "frame %u at %.4g s (%zu of %zu)", frame, seconds, i + 1, frames_.size());
      console_.note(text);
      const int one = render_frame();
      if (one != kDone) code = one;
      if (one != kDone && one != kDegraded) break;
    }
    return code;
  }

  int render_frame() {
    int code = kDone;
    for (const hd::Path& path : settings_paths()) {
      hd::host::RecordOptions options;
      set_writing(false);
      options.colors = session_.colors();
      options.keep_going = a_.keep_going;
      options.aovs = part_aovs_;
      set_checkpoint(a_, session_.scene.GetAllRenderSettings().at(path), console_, &options);
      options.cancel = &interrupted();
      options.diagnostics = console_.sink();
      options.progress = [this](const hd::host::RecordProgress& progress) {
        if (progress.fraction > 0) set_worth_saving(true);
        console_.progress(progress);
      };
      options.writing = [] { set_writing(true); };
      const RecordResult result = hd::host::RecordFrame(session_.index(), &session_.scene, path, options);
      console_.end_progress();
      stats_.add_render(session_.scene.GetAllRenderSettings().at(path), result);
      written_.insert(written_.end(), result.written.begin(), result.written.end());
      say_error(result.stats);
      const int one = exit_code(result);
      say_suspect(result.stats, one);
      if (one != kDone) code = one;
      if (one != kDone && one != kDegraded) break;
    }
    return code;
  }

  // Renders the pixel alone in each of the scene's frames that has it, and prints its paths.
  int trace_pixel() {
    const PixelChoice pixel = *parse_pixel(a_.pixel);
    const std::vector<hd::Path> paths = settings_paths();
    int code = kUsage;
    std::string sizes;
    for (const hd::Path& path : paths) {
      hd::RenderSettingsDescription settings = session_.scene.GetAllRenderSettings().at(path);
      override_size(&settings);
      const std::string size = std::to_string(settings.width) + "x" + std::to_string(settings.height);
      sizes += (sizes.empty() ? "" : " and of ") + size;
      const bool overscan = settings.window().contains(pixel.x, pixel.y);
      if (!overscan && !settings.frame_window().contains(pixel.x, pixel.y)) continue;
      if (paths.size() > 1)
        std::printf("frame of %s, for %s:\n", size.c_str(), printable(settings.products[0].file).c_str());
      code = trace_pixel(path, pixel, std::move(settings));
      if (code != kDone && code != kDegraded) return code;
    }
    if (code == kUsage) console_.usage_error("--pixel", "'" + a_.pixel + "' lies outside the frame of " + sizes + ".");
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
    const std::string pixel = " --pixel " + found->second.text_or("");
    // A terminal shows no control character as one that can be copied.
    const std::string way =
        has_control_character(a_.words) ? "add to the command:" + pixel : "run:\n  alabaster render" + pixel + a_.words;
    console_.sink()(
        {failed ? hd::Severity::error : hd::Severity::warning, "render.sample", "", what + " To see its path, " + way});
  }

  void say_error(const hd::Dictionary& stats) {
    if (const std::string text = noise_text(stats); !text.empty()) console_.note(text);
  }

  int write_stats(int code) {
    if (a_.stats.empty()) return kDone;
    nlohmann::json settings = nlohmann::json::object();
    for (const hd::RenderSettingDescriptor& descriptor : session_.delegate()->GetRenderSettingDescriptors())
      settings[descriptor.key.str()] = value_to_json(session_.delegate()->GetRenderSetting(descriptor.key));
    const char* status = code == kDone          ? "done"
                         : code == kInterrupted ? "interrupted"
                         : code == kDegraded    ? "degraded"
                                                : "failed";
    const std::string text =
        stats_.to_json(a_.scene, status, settings).dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
    set_writing(true);
    const std::string problem =
        hd::support::WriteOutputFile(a_.stats, {reinterpret_cast<const uint8_t*>(text.data()), text.size()},
                                     code == kInterrupted ? hd::support::Flush::none : hd::support::Flush::disk);
    if (problem.empty()) return kDone;
    console_.error(a_.stats, "The statistics could not be written: " + problem + ".");
    return kOutput;
  }

  void summarize() {
    char text[200];
    const double rays = stats_.total("rays.camera") + stats_.total("rays.bounce") + stats_.total("rays.shadow") +
                        stats_.total("rays.walk");
    std::snprintf(text, sizeof text, "load %.2f s, sync %.2f s, render %.2f s, write %.2f s; %.1f Mrays; peak %.0f MB",
                  stats_.load_wall(), stats_.total("phase.sync.wall"), stats_.total("phase.render.wall"),
                  stats_.total("phase.write.wall"), rays / 1e6, double(hd::support::peak_memory_bytes()) / 1e6);
    for (const std::string& file : written_) console_.note("wrote " + file);
    console_.note(text);
  }

  const RenderArguments& a_;
  const std::vector<uint32_t> frames_ = parse_frames(a_.frames);  // empty: one picture
  Console console_;
  SceneSession session_{!frames_.empty()};
  RunStats stats_;
  std::vector<std::string> written_;
  std::vector<std::string> part_aovs_;  // of a part without files
};

}  // namespace

int run_render(const RenderArguments& arguments) {
  return RenderCommand(arguments).run();
}

}  // namespace alabaster::cli
