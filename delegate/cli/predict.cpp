#include "delegate/cli/predict.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <set>
#include <thread>

#include "delegate/cli/commands.h"
#include "delegate/cli/exit_codes.h"
#include "delegate/cli/interrupt.h"
#include "delegate/cli/stopwatch.h"
#include "delegate/support/lookup.h"
#include "delegate/support/process_usage.h"
#include "delegate/tradeoff/prediction.h"
#include "delegate/tradeoff/temporary_folder.h"

namespace alabaster::cli {
namespace {

namespace fs = std::filesystem;
using hd::support::number_in;
using tradeoff::Prediction;
using tradeoff::Probe;
using tradeoff::Range;
using Json = nlohmann::ordered_json;

constexpr double kProbeSeconds = 2.5;
// Samples per pixel after which a render looks at its error for the first time.
constexpr double kFirstLook = 16;
constexpr double kPilotPixels = 1536;

double pixels_of(const hd::RenderSettingsDescription& s) {
  const hd::Rect2i window = s.window();
  return double(window.width()) * double(window.height());
}

/// The same framing at about `pixels` pixels, never more than `s` has.
hd::RenderSettingsDescription reduced(hd::RenderSettingsDescription s, double pixels) {
  const double factor = std::min(1.0, std::sqrt(pixels / pixels_of(s)));
  const auto scaled = [&](int side) { return std::max(1, static_cast<int>(std::lround(side * factor))); };
  s.width = scaled(s.width);
  s.height = scaled(s.height);
  if (s.crop) {
    const auto low = [&](int v) { return static_cast<int>(std::floor(v * factor)); };
    const auto high = [&](int v) { return static_cast<int>(std::ceil(v * factor)); };
    s.crop = hd::Rect2i{low(s.crop->minX), low(s.crop->minY), high(s.crop->maxX), high(s.crop->maxY)};
  }
  return s;
}

/// The renders of one prediction.
class ProbeRenders {
 public:
  ProbeRenders(SceneSession* session, Console* console)
      : session_(*session),
        console_(*console),
        full_(session->scene.GetAllRenderSettings().at(session->file.settings)) {}
  ~ProbeRenders() {
    if (!path_.empty()) session_.scene.Remove(path_);
  }
  ProbeRenders(const ProbeRenders&) = delete;
  ProbeRenders& operator=(const ProbeRenders&) = delete;

  /// Renders a pilot, which tells how much fits into the time, then a coarse picture and two finer ones with few and
  /// with four times as many samples. They show how the error changes with size and samples. False after a report.
  bool run() {
    const Stopwatch watch;
    // Below thirty samples a well spread sequence, or adaptive sampling's pilot, converges unlike the samples that
    // follow.
    const double few = 32, many = 4 * few;
    if (!render({kPilotPixels, few / 2, 0.2 * kProbeSeconds, false})) return false;
    if (!is_measured()) return true;
    const Probe& pilot = probes_.front();
    const double cost = pilot.cpu / (pilot.pixels * pilot.samples) / threads();
    const double left = std::max(0.9 * (kProbeSeconds - watch.wall()), 0.1 * kProbeSeconds);
    const double all = pixels_of(full_);
    const double pixels = std::clamp(left / (cost * (few / 4 + few + many)), std::min(kPilotPixels, all), all);
    if (pixels < all && !render({pixels / 4, few, left / 3, false})) return false;
    if (!render({pixels, few, left / 3, false})) return false;
    // A small frame that is probed whole has time for more samples.
    const double most = std::max(many, std::floor(left / (cost * pixels) - few));
    return render({pixels, std::min(most, 1024.0), std::max(0.3 * kProbeSeconds, kProbeSeconds - watch.wall()), true});
  }

  const std::vector<Probe>& probes() const { return probes_; }
  const hd::RenderSettingsDescription& full() const { return full_; }
  const hd::Dictionary& stats() const { return stats_; }
  const hd::RenderSettingsDescription& last() const { return last_; }
  /// The time in which products are checked. The libraries of their formats are loaded for it: a third of a second.
  const Seconds& opening() const { return opening_; }
  /// False: the noise of the last probe is not known.
  bool is_measured() const { return stats_.contains("error.relativeRmse"); }
  /// Bytes of a frame of `pixels` pixels like the last: the films (a second one holds the pixels that end early), and
  /// for each AOV the buffer (shown and being resolved) and the product (bytes and numbers).
  double frame_bytes(double pixels, int films) const {
    double bytes = films * number_in(stats_, "filmMemory") / pixels_of(last_);
    std::set<std::string> aovs;
    for (const hd::RenderProduct& product : last_.products)
      for (const hd::RenderVar& var : product.vars) aovs.insert(var.aov.str());
    if (aovs.empty()) aovs.insert("color");
    for (const std::string& aov : aovs)
      bytes += 4.0 * double(hd::FormatSize(session_.delegate()->GetDefaultAovDescriptor(aov).format));
    return bytes * pixels;
  }

 private:
  struct Plan {
    double pixels, samples, seconds;
    bool write;
  };

  double threads() const {
    const double asked = number_in(full_.settings, "threads");
    return asked > 0 ? asked : std::max(1u, std::thread::hardware_concurrency());
  }

  // Noise needs two samples per pixel: a probe of a slow scene whose time is too short for them is repeated with more.
  // Where more do not help, the picture's mean is not finite.
  bool render(Plan plan) {
    constexpr double kLongest = 600, kEnough = 4;
    while (render_once(plan)) {
      if (is_measured() || plan.seconds >= kLongest || probes_.back().samples >= kEnough) return true;
      probes_.pop_back();
      plan.seconds *= 4;
    }
    return false;
  }

  bool render_once(const Plan& plan) {
    last_ = reduced(full_, plan.pixels);
    last_.settings["denoise"] = false;
    last_.settings["samples"] = static_cast<int32_t>(plan.samples);
    last_.settings["timeLimit"] = static_cast<float>(plan.seconds);
    // Renders in rounds and allocates samples as a render to an error does, but never reaches this error.
    last_.settings["targetError"] = 1e-6f;
    last_.settings["seed"] = static_cast<int32_t>(probes_.size() + 1);  // each probe takes samples of its own
    last_.products.clear();
    set_writing(plan.write);  // even a second signal must not leave the folder behind
    std::optional<tradeoff::TemporaryFolder> folder;
    if (plan.write) {
      const Stopwatch watch;
      last_.products = products_in(folder.emplace("alabaster-probe-").path());
      opening_ = {watch.wall(), watch.cpu()};
    }
    path_ = session_.file.settings.append("probe");
    session_.scene.SetRenderSettings(path_, last_);
    hd::host::RecordOptions options;
    options.colors = session_.colors();
    options.cancel = &interrupted();
    options.diagnostics = [show = console_.sink()](const hd::Diagnostic& d) {
      if (d.code != "record.timeLimit" && d.code != "record.targetError") show(d);
    };
    const auto result = hd::host::RecordFrame(session_.index(), &session_.scene, path_, options);
    folder.reset();
    set_writing(false);
    if (result.status != hd::host::RecordStatus::done) return false;
    stats_ = result.stats;
    const double pixels = pixels_of(last_);
    probes_.push_back({pixels, number_in(stats_, "rays.camera") / pixels, number_in(stats_, "phase.render.wall"),
                       number_in(stats_, "phase.render.cpu"), number_in(stats_, "error.relativeRmse"),
                       number_in(stats_, "error.low"), number_in(stats_, "error.high"),
                       number_in(stats_, "error.groupsOverFrame", 1)});
    return true;
  }

  /// The scene's products (an EXR if it names none), redirected to `folder`. Empty if there is no folder or they cannot
  /// be written.
  std::vector<hd::RenderProduct> products_in(const fs::path& folder) const {
    if (folder.empty()) return {};
    std::vector<hd::RenderProduct> products = full_.products;
    if (products.empty()) products.emplace_back().file = "probe.exr";
    for (size_t i = 0; i < products.size(); ++i) {
      products[i].within.clear();
      products[i].file = folder / (std::to_string(i) + fs::path(products[i].file).extension().string());
      if (!hd::host::CheckProduct(products[i], full_.window(), session_.colors(), {})) return {};
    }
    return products;
  }

  SceneSession& session_;
  Console& console_;
  const hd::RenderSettingsDescription full_;
  hd::RenderSettingsDescription last_;
  hd::Path path_;
  hd::Dictionary stats_;  // of the last probe
  Seconds opening_{};
  std::vector<Probe> probes_;
};

std::string amount_text(double value) {
  return formatted(value >= 100 ? "%.0f" : value >= 1 ? "%.3g" : "%.2g", value);
}

// Adds a cost that was measured once; the next time it will be a little different.
Range plus(const Range& range, double fixed) {
  return {range.value + fixed, range.low + 0.8 * fixed, range.high + 1.25 * fixed};
}

/// Loading may have caused the process's peak, and the frame may fit below it: then the lower end holds.
Range memory(const ProbeRenders& renders) {
  const double peak = double(hd::support::peak_memory_bytes());
  const double probe = renders.frame_bytes(pixels_of(renders.last()), 1);
  const double frame = renders.frame_bytes(pixels_of(renders.full()), 2);
  const double low = std::max(peak, double(hd::support::resident_memory_bytes()) - probe + frame),
               high = peak - probe + frame;
  return {(low + high) / 2 / 1e6, 0.95 * low / 1e6, 1.1 * high / 1e6};
}

Json range_json(const Range& range) {
  return {{"value", range.value}, {"low", range.low}, {"high", range.high}};
}

Json prediction_json(const ProbeRenders& renders, const Preparation& spent, double target) {
  const Prediction p = tradeoff::predict(renders.probes(), pixels_of(renders.full()), target, kFirstLook);
  const double growth = pixels_of(renders.full()) / pixels_of(renders.last());
  const hd::Dictionary& stats = renders.stats();
  const auto of_frame = [&](const char* seconds) { return number_in(stats, seconds) * growth; };
  const Seconds write{of_frame("phase.write.wall"), of_frame("phase.write.cpu")};
  const Seconds load{spent.load.wall + renders.opening().wall, spent.load.cpu + renders.opening().cpu};
  return {{"targetError", target},
          {"resolution", {renders.full().width, renders.full().height}},
          {"samplesPerPixel", range_json(p.samples)},
          {"wallSeconds", range_json(plus(p.wall, load.wall + spent.sync.wall + write.wall))},
          {"cpuSeconds", range_json(plus(p.cpu, load.cpu + spent.sync.cpu + write.cpu))},
          {"peakMegabytes", range_json(memory(renders))},
          {"phases",
           {{"load", load.wall},
            {"refine", number_in(stats, "sync.refineWallSeconds")},
            {"build", number_in(stats, "sync.bvhWallSeconds")},
            {"render", p.wall.value},
            {"write", write.wall}}},
          {"mostSamples", int64_t(number_in(renders.full().settings, "samples"))},
          {"denoises", number_in(renders.full().settings, "denoise") != 0},
          {"timeLimit", number_in(renders.full().settings, "timeLimit")},
          {"isNoisy", p.noisy}};
}

std::string dimensions(const Json& resolution) {
  return resolution[0].dump() + "x" + resolution[1].dump();
}

}  // namespace

int predict(SceneSession* session, Console* console, const Preparation& spent, double target, Json* scene) {
  const Stopwatch watch;
  ProbeRenders renders(session, console);
  set_worth_saving(true);  // from here on a signal stops the probe, which then cleans up after itself
  const bool done = renders.run();
  set_worth_saving(false);
  if (interrupted()) {
    console->note("interrupted before a prediction could be made");
    return kInterrupted;
  }
  if (!done) return kRender;
  if (!renders.is_measured()) {
    console->error("--predict",
                   "The mean of the picture is not finite, so that its noise has no measure; find lights, "
                   "emissions or exposures that are too large.");
    return kRender;
  }
  Json prediction = prediction_json(renders, spent, target);
  prediction["probe"] = {{"seconds", watch.wall()}, {"resolution", {renders.last().width, renders.last().height}}};
  (*scene)["prediction"] = std::move(prediction);
  return kDone;
}

void print_prediction(const Json& p) {
  std::printf("predicted for %s %% relative RMSE at %s, from a probe of %.1f s at %s:\n",
              amount_text(100 * p["targetError"].get<double>()).c_str(), dimensions(p["resolution"]).c_str(),
              p["probe"]["seconds"].get<double>(), dimensions(p["probe"]["resolution"]).c_str());
  std::string phases;
  for (const auto& [name, seconds] : p["phases"].items())
    phases += (phases.empty() ? ": " : ", ") + name + " " + amount_text(seconds);
  const struct {
    const char *title, *key, *unit;
    std::string more;
  } rows[] = {{"samples per pixel", "samplesPerPixel", "", ""},
              {"wall time", "wallSeconds", " s", phases},
              {"CPU time", "cpuSeconds", " s", ""},
              {"peak memory", "peakMegabytes", " MB", ""}};
  for (const auto& [title, key, unit, more] : rows)
    std::printf("  %-18s %s%s (%s to %s)%s\n", title, amount_text(p[key]["value"]).c_str(), unit,
                amount_text(p[key]["low"]).c_str(), amount_text(p[key]["high"]).c_str(), more.c_str());
  if (!p["isNoisy"])
    std::printf("  the picture is black or noise-free: the render ends when it first estimates its error\n");
  else
    std::printf(
        "  light that the probe has not met, such as a caustic or the sun in a mirror, would take more samples\n");
  if (p["samplesPerPixel"]["high"] > p["mostSamples"])
    std::printf("  a render with --target-error stops at %s samples per pixel: add --spp to allow more\n",
                p["mostSamples"].dump().c_str());
  if (p["timeLimit"] > 0 && p["phases"]["render"] > p["timeLimit"])
    std::printf("  its time limit of %.3g s comes first\n", p["timeLimit"].get<double>());
  if (p["denoises"]) std::printf("  denoising the picture takes time and memory beside these\n");
}

}  // namespace alabaster::cli
