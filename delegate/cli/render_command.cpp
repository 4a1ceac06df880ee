#include <cstdio>
#include <filesystem>
#include <set>
#include <sstream>

#include "delegate/cli/commands.h"
#include "delegate/cli/exit_codes.h"
#include "delegate/cli/interrupt.h"
#include "delegate/cli/outputs.h"
#include "delegate/cli/stats_file.h"
#include "delegate/cli/stopwatch.h"

namespace alabaster::cli {
namespace {

namespace fs = std::filesystem;
using hd::host::RecordResult;
using hd::host::RecordStatus;

class RenderCommand {
 public:
  explicit RenderCommand(const RenderArguments& arguments) : a_(arguments), console_(arguments.quiet) {}

  int run() {
    catch_interrupts();
    int code = check_arguments();
    if (code == kDone) code = load();
    if (code == kDone) code = plan_products();
    if (code != kDone) return code;
    if (!session_.start(colors().ocio, console_.sink())) return kRender;
    code = render();
    if (const int stats_code = write_stats(code); code == kDone) code = stats_code;
    if (code == kDone) summarize();
    return code;
  }

 private:
  int usage_error(const std::string& where, const std::string& text) {
    console_.error(where, text);
    return kUsage;
  }

  hd::host::OutputColors colors() const { return {a_.ocio.empty() ? session_.file.color_config : a_.ocio}; }

  // What can be refused without reading the scene.
  int check_arguments() {
    if (!a_.size.empty() && size_value(a_.size).empty())
      return usage_error("--size", "'" + a_.size + "' is no resolution: write for example 1280x720.");
    if (!a_.crop.empty() && crop_value(a_.crop).empty())
      return usage_error("--crop", "'" + a_.crop + "' is no rectangle: write four whole numbers, x0,y0,x1,y1.");
    if (!a_.stats.empty()) {
      const fs::path folder = fs::path(a_.stats).parent_path();
      std::error_code error;
      if (!folder.empty() && !fs::is_directory(folder, error)) {
        console_.error(a_.stats, "The folder does not exist: create it, or write elsewhere.");
        return kOutput;
      }
    }
    // Files that a description names are checked once it is loaded; --ocio and -o need no scene.
    if (a_.outputs.empty()) return kDone;
    std::string problem;
    const auto products = make_products(a_, {}, &problem);
    if (!problem.empty()) return usage_error("render", problem);
    // A config named by the scene is not known yet, so names of displays are checked later.
    for (hd::RenderProduct product : products) {
      product.display = product.view = product.look = "";
      if (!hd::host::CheckProduct(product, {}, console_.sink())) return kOutput;
    }
    return kDone;
  }

  hd::description::LoadOptions load_options() const {
    hd::description::LoadOptions options;
    const auto add = [&](const char* key, const std::string& value) {
      if (!value.empty()) options.overrides.push_back(std::string(key) + "=" + value);
    };
    if (a_.time) add("frame", std::to_string(static_cast<uint64_t>(*a_.time)));
    add("resolution", size_value(a_.size));
    add("crop", crop_value(a_.crop));
    add("samples", a_.samples);
    add("seed", a_.seed);
    add("threads", a_.threads);
    add("maxDepth", a_.max_depth);
    add("subsurface", a_.subsurface);
    add("inversion", a_.inversion);
    options.overrides.insert(options.overrides.end(), a_.overrides.begin(), a_.overrides.end());
    options.camera = a_.camera;
    options.dome = a_.dome;
    return options;
  }

  int load() {
    const Stopwatch watch;
    const hd::description::LoadOptions options = load_options();
    const bool ok = session_.load(a_.scene, options, console_.sink());
    stats_.set_load(watch.wall(), watch.cpu());
    if (!ok) {
      // What the command line asked for carries its own text as the place: a fault there is one of usage.
      std::set<std::string> asked(options.overrides.begin(), options.overrides.end());
      asked.insert("camera " + a_.camera);
      asked.insert("dome " + a_.dome);
      return asked.count(console_.last_error_place()) ? kUsage : kInput;
    }
    for (const std::string& note : session_.file.notes) console_.note("note: " + note);
    if (a_.time) console_.note("note: scenes do not move yet; --time only numbers the frame");
    return kDone;
  }

  std::vector<hd::Path> settings_paths() const {
    std::vector<hd::Path> paths{session_.file.settings};
    if (a_.outputs.empty())
      paths.insert(paths.end(), session_.file.further_settings.begin(), session_.file.further_settings.end());
    return paths;
  }

  // Gives every render its products, sizes and crops, and checks all files before anything is rendered.
  int plan_products() {
    const auto all = session_.scene.GetAllRenderSettings();
    const hd::RenderSettingsDescription& first = all.at(session_.file.settings);
    if (!a_.outputs.empty())
      for (const hd::Path& path : session_.file.further_settings) session_.scene.Remove(path);
    std::vector<hd::RenderProduct> described;
    for (const hd::Path& path : settings_paths())
      described.insert(described.end(), all.at(path).products.begin(), all.at(path).products.end());
    std::string problem;
    const auto products = make_products(a_, described, &problem);
    if (!problem.empty()) return usage_error("render", problem);
    size_t next = 0;
    for (const hd::Path& path : settings_paths()) {
      hd::RenderSettingsDescription settings = a_.outputs.empty() ? all.at(path) : first;
      const size_t count = a_.outputs.empty() ? settings.products.size() : products.size();
      settings.products.assign(products.begin() + static_cast<std::ptrdiff_t>(next),
                               products.begin() + static_cast<std::ptrdiff_t>(next + count));
      next += count;
      override_size(&settings);
      for (const hd::RenderProduct& product : settings.products)
        if (!hd::host::CheckProduct(product, colors(), console_.sink())) return kOutput;
      session_.scene.SetRenderSettings(path, std::move(settings));
    }
    return kDone;
  }

  // --size and --crop have gone into the first settings while loading; they outrank what single products ask for.
  void override_size(hd::RenderSettingsDescription* settings) const {
    if (!a_.size.empty()) {
      std::istringstream text(a_.size);
      char separator = 'x';
      text >> settings->width >> separator >> settings->height;
    }
    if (!a_.crop.empty()) {
      std::istringstream text(a_.crop);
      char separator = ',';
      hd::Rect2i c;
      text >> c.minX >> separator >> c.minY >> separator >> c.maxX >> separator >> c.maxY;
      settings->crop = c;
    }
  }

  int render() {
    int code = kDone;
    for (const hd::Path& path : settings_paths()) {
      hd::host::RecordOptions options;
      options.colors = colors();
      options.cancel = &interrupted();
      options.diagnostics = console_.sink();
      options.progress = [this](const hd::host::RecordProgress& progress) {
        if (progress.fraction > 0) set_worth_saving(true);
        console_.progress(progress);
      };
      const RecordResult result = hd::host::RecordFrame(session_.index(), &session_.scene, path, options);
      console_.end_progress();
      stats_.add_render(session_.scene.GetAllRenderSettings().at(path), result);
      written_.insert(written_.end(), result.written.begin(), result.written.end());
      code = exit_code(result.status);
      if (code != kDone) break;
    }
    if (code == kInterrupted) {
      for (const std::string& file : written_) console_.note("interrupted: wrote what there is to " + file);
      if (written_.empty()) console_.note("interrupted: nothing was written");
    }
    return code;
  }

  static int exit_code(RecordStatus status) {
    switch (status) {
      case RecordStatus::done:
        return kDone;
      case RecordStatus::input_failed:
        return kInput;
      case RecordStatus::render_failed:
        return kRender;
      case RecordStatus::output_failed:
        return kOutput;
      case RecordStatus::interrupted:
        return kInterrupted;
    }
    return kRender;
  }

  int write_stats(int code) {
    if (a_.stats.empty()) return kDone;
    nlohmann::json settings = nlohmann::json::object();
    for (const hd::RenderSettingDescriptor& descriptor : session_.delegate()->GetRenderSettingDescriptors())
      settings[descriptor.key.str()] = value_to_json(session_.delegate()->GetRenderSetting(descriptor.key));
    const char* status = code == kDone ? "done" : code == kInterrupted ? "interrupted" : "failed";
    std::string problem;
    if (write_text_file(a_.stats, stats_.to_json(a_.scene, status, settings).dump(2) + "\n", &problem)) return kDone;
    console_.error(a_.stats, "The statistics cannot be written: " + problem + ".");
    return kOutput;
  }

  void summarize() {
    char text[200];
    const double rays = stats_.total("rays.camera") + stats_.total("rays.bounce") + stats_.total("rays.shadow") +
                        stats_.total("rays.walk");
    std::snprintf(text, sizeof text, "load %.2f s, sync %.2f s, render %.2f s, write %.2f s; %.1f Mrays; peak %.0f MB",
                  stats_.load_wall(), stats_.total("phase.sync.wall"), stats_.total("phase.render.wall"),
                  stats_.total("phase.write.wall"), rays / 1e6, double(peak_memory_bytes()) / 1e6);
    for (const std::string& file : written_) console_.note("wrote " + file);
    console_.note(text);
  }

  const RenderArguments& a_;
  Console console_;
  SceneSession session_;
  RunStats stats_;
  std::vector<std::string> written_;
};

}  // namespace

int run_render(const RenderArguments& arguments) {
  return RenderCommand(arguments).run();
}

}  // namespace alabaster::cli
