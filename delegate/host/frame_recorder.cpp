#include "delegate/host/frame_recorder.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstring>
#include <ctime>
#include <set>
#include <thread>

#include "delegate/support/process_usage.h"

namespace alabaster::hd::host {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// For destructors: what cannot be tidied up is left, and the host goes on.
template <class Body>
void quietly(const Body& body) noexcept {
  try {
    body();
  } catch (...) {
  }
}

/// Wall and CPU seconds of one phase, noted in the statistics when it ends.
class Phase {
 public:
  Phase(Dictionary* stats, std::string name) : stats_(stats), name_("phase." + std::move(name)) {}
  ~Phase() {
    quietly([&] {
      (*stats_)[name_ + ".wall"] = seconds_since(wall_);
      (*stats_)[name_ + ".cpu"] = support::process_cpu_seconds() - cpu_;
    });
  }
  Phase(const Phase&) = delete;
  Phase& operator=(const Phase&) = delete;

 private:
  Dictionary* stats_;
  std::string name_;
  Clock::time_point wall_ = Clock::now();
  double cpu_ = support::process_cpu_seconds();
};

/// Stops the delegate as soon as the host cancels, while the calling thread is inside Sync.
class CancelWatch {
 public:
  CancelWatch(const std::atomic<bool>* cancel, RenderDelegate* delegate) {
    if (cancel) thread_ = std::thread([this, cancel, delegate] { watch(*cancel, delegate); });
  }
  ~CancelWatch() {
    {
      const std::lock_guard lock(mutex_);
      over_ = true;
    }
    changed_.notify_all();
    if (thread_.joinable()) thread_.join();
  }
  CancelWatch(const CancelWatch&) = delete;
  CancelWatch& operator=(const CancelWatch&) = delete;

 private:
  void watch(const std::atomic<bool>& cancel, RenderDelegate* delegate) {
    std::unique_lock lock(mutex_);
    while (!changed_.wait_for(lock, std::chrono::milliseconds(10), [this] { return over_; })) {
      if (!cancel) continue;
      lock.unlock();
      delegate->Stop();
      return;
    }
  }
  std::mutex mutex_;
  std::condition_variable changed_;
  bool over_ = false;
  std::thread thread_;
};

std::string utc_now() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text;
}

double stat(const Dictionary& stats, const char* key) {
  const auto found = stats.find(key);
  return found == stats.end() ? 0 : found->second.number_or(0);
}

/// One recording, from checks to files.
class Recording {
 public:
  Recording(RenderIndex* index, RetainedSceneDelegate* scene, const Path& settings, const RecordOptions& options)
      : index_(index), scene_(scene), delegate_(index->GetRenderDelegate()), settings_(settings), options_(options) {}

  /// The net under record(): the host's callbacks, memory and threads may all fail.
  RecordResult run() noexcept {
    try {
      record();
    } catch (const std::exception& e) {
      refuse_exception(e.what());
    } catch (...) {
      refuse_exception("unknown reason");
    }
    return std::move(result_);
  }

 private:
  static constexpr const char* kSettingsPath = "renderSettingsPrimPath";

  /// What a recording changes in host and delegate, put back however it ends.
  class Borrowed {
   public:
    explicit Borrowed(Recording* recording)
        : recording_(recording), previous_(recording->delegate_->GetRenderSetting(kSettingsPath)) {
      recording_->delegate_->SetRenderSetting(kSettingsPath, recording_->settings_);
    }
    ~Borrowed() {
      for (const auto& buffer : recording_->buffers_) quietly([&] { recording_->scene_->Remove(buffer.second); });
      quietly([&] { recording_->delegate_->SetRenderSetting(kSettingsPath, previous_); });
      if (recording_->delegate_->IsStopped()) recording_->delegate_->Restart();
    }
    Borrowed(const Borrowed&) = delete;
    Borrowed& operator=(const Borrowed&) = delete;

   private:
    Recording* recording_;
    Value previous_;
  };

  void record() {
    if (!prepare()) return;
    const Borrowed borrowed(this);
    allocate();
    if (!sync()) return;
    if (!cancelled() && have_buffers()) render();
    collect_stats();
    if (result_.status == RecordStatus::done || (result_.status == RecordStatus::interrupted && rendered_)) write();
  }

  void refuse_exception(const char* what) noexcept {
    result_.status = RecordStatus::render_failed;
    quietly([&] { report("record.exception", std::string("failed: ") + what); });
  }

  bool refuse(RecordStatus status, const char* code, const std::string& text) {
    result_.status = status;
    report(code, text);
    return false;
  }

  void report(const char* code, const std::string& text) const {
    if (options_.diagnostics) options_.diagnostics({Severity::error, code, settings_.str(), text});
  }

  // Everything that can be known to fail is refused before anything is rendered.
  bool prepare() {
    const auto found = scene_->GetAllRenderSettings().find(settings_);
    if (found == scene_->GetAllRenderSettings().end())
      return refuse(RecordStatus::input_failed, "record.settings", "there are no such render settings");
    description_ = found->second;
    if (description_.width < 1 || description_.height < 1 || description_.width > 65536 || description_.height > 65536)
      return refuse(RecordStatus::input_failed, "record.resolution", "width and height must lie in 1..65536");
    if (!can_look())
      return refuse(RecordStatus::input_failed, "record.camera",
                    "the transform of camera " + description_.camera.str() +
                        " is not finite or cannot be inverted: it may be scaled to zero");
    window_ = description_.crop.value_or(Rect2i{0, 0, description_.width, description_.height});
    const auto fits = [](int first, int last) { return first < last && int64_t(last) - first <= 65536; };
    if (!fits(window_.minX, window_.maxX) || !fits(window_.minY, window_.maxY) || !(description_.pixelAspectRatio > 0))
      return refuse(RecordStatus::input_failed, "record.framing",
                    "the crop must be 1 to 65536 pixels wide and high, and pixelAspectRatio must be positive");
    if (window_.minX >= description_.width || window_.minY >= description_.height || window_.maxX <= 0 ||
        window_.maxY <= 0)
      return refuse(RecordStatus::input_failed, "record.crop",
                    "the crop lies wholly outside the frame of " + std::to_string(description_.width) + " x " +
                        std::to_string(description_.height) + " pixels");
    std::set<std::string> aovs;
    for (const RenderProduct& product : description_.products) {
      if (!CheckProduct(product, options_.colors, options_.diagnostics)) {
        result_.status = RecordStatus::output_failed;
        return false;
      }
      if (product.vars.empty()) aovs.insert("color");
      for (const RenderVar& var : product.vars) aovs.insert(var.aov.str());
    }
    if (aovs.empty()) aovs.insert("color");
    for (const std::string& aov : aovs) {
      if (delegate_->GetDefaultAovDescriptor(aov).format == Format::invalid)
        return refuse(RecordStatus::input_failed, "record.aov", "AOV '" + aov + "' is not supported");
      buffers_[aov] = settings_.append("buffer_" + aov);
    }
    return true;
  }

  void allocate() {
    for (const auto& [aov, path] : buffers_) {
      RenderBufferDescriptor buffer;
      buffer.dimensions = {window_.width(), window_.height(), 1};
      buffer.format = delegate_->GetDefaultAovDescriptor(aov).format;
      scene_->SetRenderBuffer(path, buffer);
    }
    if (!index_->Has(settings_)) scene_->Populate(index_);
  }

  bool cancelled() {
    if (options_.cancel && *options_.cancel) result_.status = RecordStatus::interrupted;
    return result_.status == RecordStatus::interrupted;
  }

  bool sync() {
    const Phase phase(&phases_, "sync");
    const CancelWatch watch(options_.cancel, delegate_);
    return index_->SyncAll() || refuse(RecordStatus::render_failed, "record.sync",
                                       "the scene could not be synced: memory or threads ran out");
  }

  // A delegate refuses buffers that are too large, and says so: rendering without them would be for nothing.
  // A camera that does not exist is the pass' to refuse.
  bool can_look() const {
    const auto camera = scene_->GetCameras().find(description_.camera);
    if (camera == scene_->GetCameras().end()) return true;
    const double determinant = camera->second.transform.determinant();
    return std::isfinite(determinant) && determinant != 0;
  }

  bool have_buffers() {
    for (const auto& [aov, path] : buffers_) {
      const auto* buffer = static_cast<RenderBuffer*>(index_->GetBprim(path));
      if (!buffer || buffer->GetWidth() != window_.width() || buffer->GetHeight() != window_.height())
        return refuse(RecordStatus::input_failed, "record.buffer",
                      "AOV '" + aov + "' cannot have " + std::to_string(window_.width()) + " x " +
                          std::to_string(window_.height()) + " pixels; lower the resolution or render a crop");
    }
    return true;
  }

  RenderPassState pass_state() const {
    RenderPassState state;
    state.camera = description_.camera;
    // Buffers are as large as the data window; the display window is moved so that it starts at their corner.
    const Vec2f corner(static_cast<float>(window_.minX), static_cast<float>(window_.minY));
    state.framing.displayMin = -corner;
    state.framing.displayMax =
        Vec2f(static_cast<float>(description_.width), static_cast<float>(description_.height)) - corner;
    state.framing.dataWindow = {0, 0, window_.width(), window_.height()};
    state.framing.pixelAspectRatio = description_.pixelAspectRatio;
    state.windowPolicy = description_.windowPolicy;
    for (const auto& [aov, path] : buffers_) {
      AovBinding binding;
      binding.aovName = aov;
      binding.renderBuffer = static_cast<RenderBuffer*>(index_->GetBprim(path));
      state.aovBindings.push_back(binding);
    }
    return state;
  }

  void render() {
    const Phase phase(&phases_, "render");
    started_ = Clock::now();
    const std::unique_ptr<RenderPass> pass = delegate_->CreateRenderPass();
    if (!pass) {
      refuse(RecordStatus::render_failed, "record.pass", "the delegate made no render pass");
      return;
    }
    const RenderPassState state = pass_state();
    pass->Execute(state);
    double told = 0;
    while (!pass->IsConverged() && !cancelled()) {
      pass->WaitForConvergence(0.02);
      if (delegate_->IsStopped()) result_.status = RecordStatus::interrupted;  // by another thread
      pass->Execute(state);
      if (const double now = seconds_since(started_); options_.progress && now - told >= 0.1) {
        told = now;
        options_.progress(progress());
      }
    }
    if (cancelled()) delegate_->Stop();
    if (pass->GetState() == PassState::failed) result_.status = RecordStatus::render_failed;
    result_.stats = delegate_->GetRenderStats();  // while the pass lives
    if (options_.progress) options_.progress(progress());
    rendered_ = true;
    if (options_.writing) options_.writing();
    read_pixels();
  }

  RecordProgress progress() const {
    const Dictionary stats = delegate_->GetRenderStats();
    RecordProgress p;
    p.fraction = stat(stats, "fractionDone");
    p.seconds = seconds_since(started_);
    const double rays =
        stat(stats, "rays.camera") + stat(stats, "rays.bounce") + stat(stats, "rays.shadow") + stat(stats, "rays.walk");
    const double rendering = stat(stats, "totalClockTime");
    p.rays_per_second = rendering > 0 ? rays / rendering : 0;
    p.seconds_left = p.fraction > 0.005 ? rendering * (1 - p.fraction) / p.fraction : -1;
    p.samples_done = static_cast<uint64_t>(stat(stats, "numCompletedSamples"));
    p.samples_total = static_cast<uint64_t>(stat(stats, "samplesTotal"));
    return p;
  }

  // Every AOV at once; an interrupted render must not keep anyone waiting.
  void read_pixels() {
    std::vector<std::pair<std::string, AovPixels>> read;
    for (const auto& [aov, path] : buffers_) read.emplace_back(aov, AovPixels());
    tbb::task_arena arena;
    arena.execute([&] {
      tbb::parallel_for(size_t(0), read.size(), [&](size_t i) {
        auto* buffer = static_cast<RenderBuffer*>(index_->GetBprim(buffers_.at(read[i].first)));
        if (buffer) read[i].second = pixels_of(*buffer);
      });
    });
    for (auto& [aov, pixels] : read) {
      if (pixels.components > 0)
        image_.aovs[aov] = std::move(pixels);
      else if (result_.status == RecordStatus::done)
        refuse(RecordStatus::render_failed, "record.buffer", "AOV '" + aov + "' has no pixels");
    }
  }

  // Without components if it has no pixels.
  AovPixels pixels_of(RenderBuffer& buffer) const {
    AovPixels pixels;
    std::vector<uint8_t> bytes;
    if (buffer.ResolveTo(&bytes, true) != Vec2i(window_.width(), window_.height())) return pixels;
    const Format format = buffer.GetFormat();
    pixels.components = FormatComponents(format);
    pixels.integer = format == Format::int32;
    if (pixels.integer) {
      pixels.ints.resize(bytes.size() / sizeof(int32_t));
      std::memcpy(pixels.ints.data(), bytes.data(), bytes.size());
    } else {
      pixels.floats.resize(bytes.size() / sizeof(float));
      std::memcpy(pixels.floats.data(), bytes.data(), bytes.size());
    }
    return pixels;
  }

  void collect_stats() {
    if (result_.stats.empty()) result_.stats = delegate_->GetRenderStats();
    for (const auto& [key, value] : phases_) result_.stats[key] = value;
  }

  void describe_image() {
    const auto width = static_cast<float>(description_.width), height = static_cast<float>(description_.height);
    image_.framing.displayMax = {width, height};
    image_.framing.dataWindow = window_;
    image_.framing.pixelAspectRatio = description_.pixelAspectRatio;
    image_.incomplete = result_.status == RecordStatus::interrupted;
    Dictionary& m = image_.metadata;
    m["capDate"] = utc_now();
    m["alabaster/camera"] = description_.camera.str();
    m["alabaster/frame"] = description_.frame;
    for (const RenderSettingDescriptor& setting : delegate_->GetRenderSettingDescriptors())
      m["alabaster/" + setting.key.str()] = delegate_->GetRenderSetting(setting.key);
    m["alabaster/samplesDone"] = result_.stats["numCompletedSamples"];
    for (const char* key : {"relativeRmse", "low", "high"})
      if (const auto found = result_.stats.find(std::string("error.") + key); found != result_.stats.end())
        m[std::string("alabaster/error/") + key] = found->second;
    m["alabaster/renderSeconds"] = result_.stats["totalClockTime"];
    m["alabaster/cpuSeconds"] = result_.stats["cpuSeconds"];
    m["alabaster/peakMemory"] = result_.stats["peakMemory"];
  }

  void write() {
    const Phase phase(&result_.stats, "write");
    describe_image();
    if (options_.picture) options_.picture(image_);
    result_.written = WriteProducts(description_.products, image_, options_.colors, options_.diagnostics);
    if (result_.written.size() < description_.products.size() && result_.status == RecordStatus::done)
      result_.status = RecordStatus::output_failed;
  }

  RenderIndex* index_;
  RetainedSceneDelegate* scene_;
  RenderDelegate* delegate_;
  Path settings_;
  const RecordOptions& options_;
  RenderSettingsDescription description_;
  Rect2i window_;
  std::map<std::string, Path> buffers_;  // by AOV
  Clock::time_point started_;
  bool rendered_ = false;
  ProductImage image_;
  Dictionary phases_;
  RecordResult result_;
};

}  // namespace

RecordResult RecordFrame(RenderIndex* index, RetainedSceneDelegate* scene, const Path& settings,
                         const RecordOptions& options) {
  return Recording(index, scene, settings, options).run();
}

}  // namespace alabaster::hd::host
