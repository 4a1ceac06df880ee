#include "delegate/host/frame_recorder.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <chrono>
#include <condition_variable>
#include <ctime>
#include <optional>
#include <thread>

#include "core/film/aov.h"
#include "core/math/float_environment.h"
#include "core/texture/texture.h"
#include "delegate/host/frame_request.h"
#include "delegate/host/recorded_checkpoints.h"
#include "delegate/support/lookup.h"
#include "delegate/support/process_usage.h"
#include "delegate/support/size_text.h"

namespace alabaster::hd::host {
namespace {

using support::number_in;
using support::text_in;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// A render buffer in no scene and no index. Whatever happens to these, it stays until this is destroyed.
class OwnBuffer {
 public:
  /// Without a buffer if the delegate makes none.
  OwnBuffer(RenderDelegate* delegate, const Path& id, const RenderBufferDescriptor& description) : delegate_(delegate) {
    Bprim* const made = delegate->CreateBprim("renderBuffer", id);
    buffer_ = dynamic_cast<RenderBuffer*>(made);
    if (buffer_)
      buffer_->Allocate(description);
    else if (made)
      delegate->DestroyBprim(made);
  }
  ~OwnBuffer() {
    if (!buffer_) return;
    buffer_->Finalize(delegate_->GetRenderParam());
    delegate_->DestroyBprim(buffer_);
  }
  OwnBuffer(const OwnBuffer&) = delete;
  OwnBuffer& operator=(const OwnBuffer&) = delete;
  RenderBuffer* get() const { return buffer_; }

 private:
  RenderDelegate* delegate_;
  RenderBuffer* buffer_ = nullptr;
};

/// Runs a step of a destructor. If it fails, its work is left undone and the host goes on.
template <class Body>
void quietly(const Body& body) noexcept {
  try {
    body();
  } catch (...) {
  }
}

/// Notes the wall and CPU seconds of one phase in the statistics when it ends.
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

/// Ends the calling thread's Sync as soon as the host cancels.
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
      stop_ = delegate->HoldStopped();
      return;
    }
  }
  std::shared_ptr<const void> stop_;  // thread_ writes it, and is joined before it dies
  std::mutex mutex_;
  std::condition_variable changed_;
  bool over_ = false;
  std::thread thread_;
};

/// A buffer's pixels, resolved and mapped.
class MappedPixels {
 public:
  MappedPixels(RenderBuffer* buffer, const Vec2i& size) : buffer_(buffer) {
    buffer->Resolve();
    const void* data = buffer->Map();
    mapped_ = data != nullptr;
    if (!data || Vec2i(buffer->GetWidth(), buffer->GetHeight()) != size) return;
    const Format format = buffer->GetFormat();
    pixels.components = FormatComponents(format);
    const size_t values =
        static_cast<size_t>(size.x) * static_cast<size_t>(size.y) * FormatSize(format) / sizeof(float);
    if (format == Format::int32)
      pixels.ints = {static_cast<const int32_t*>(data), values};
    else
      pixels.floats = {static_cast<const float*>(data), values};
  }
  ~MappedPixels() {
    if (mapped_) buffer_->Unmap();
  }
  MappedPixels(const MappedPixels&) = delete;
  MappedPixels& operator=(const MappedPixels&) = delete;

  AovPixels pixels;  // empty if there are none

 private:
  RenderBuffer* buffer_;
  bool mapped_ = false;
};

/// One recording, from checks to files: picture by picture.
class Recording {
 public:
  Recording(RenderIndex* index, RetainedSceneDelegate* scene, const Path& settings, const RecordOptions& options)
      : index_(index),
        scene_(scene),
        delegate_(index->GetRenderDelegate()),
        settings_(settings),
        options_(options),
        checkpoints_(delegate_, options, settings) {}

  /// Catches everything: the host's callbacks, memory and threads may all fail.
  RecordResult run() noexcept {
    try {
      FramePlan& plan = options_.plan;
      if (!plan.pictures) plan = PlanFrame(*scene_, settings_, *delegate_, options_);
      options_.colors.held = plan.colors;
      end(plan);
      if (plan.pictures)
        for (at_ = 0; at_ < plan.pictures->size() && succeeded(); ++at_) record();
    } catch (const std::exception& e) {
      refuse_exception(e.what());
    } catch (...) {
      refuse_exception("unknown reason");
    }
    return std::move(result_);
  }

 private:
  static constexpr const char* kSettingsPath = "renderSettingsPrimPath";

  /// Puts back whatever the recording changed in the delegate, however it ends.
  class Borrowed {
   public:
    explicit Borrowed(Recording* recording)
        : recording_(recording), previous_(recording->delegate_->GetRenderSetting(kSettingsPath)) {
      recording_->delegate_->SetRenderSetting(kSettingsPath, recording_->settings_);
    }
    ~Borrowed() {
      recording_->buffers_.clear();
      quietly([&] { recording_->delegate_->SetRenderSetting(kSettingsPath, previous_); });
    }
    Borrowed(const Borrowed&) = delete;
    Borrowed& operator=(const Borrowed&) = delete;

   private:
    Recording* recording_;
    Value previous_;
  };

  void end(RecordEnd end) { static_cast<RecordEnd&>(result_) = std::move(end); }
  bool succeeded() const { return result_.status == RecordStatus::done || result_.status == RecordStatus::degraded; }
  const FrameRequest& request() const { return (*options_.plan.pictures)[at_]; }

  void record() {
    rendered_ = false;
    result_.stats.clear();
    const Borrowed borrowed(this);
    allocate();
    if (!sync()) return;
    if (!interrupted() && have_buffers() && scene_is_whole() && resume()) render();
    collect_stats();
    const bool is_cancelled = result_.status == RecordStatus::interrupted;
    if (rendered_ && (succeeded() || (is_cancelled && !options_.drops_incomplete))) write();
    if (const std::string& fault = checkpoints_.last_fault(); !fault.empty() && succeeded())
      end({RecordStatus::output_failed, RecordedCheckpoints::kCode, fault});
  }

  bool resume() {
    const CommandResult resumed = checkpoints_.resume();
    if (resumed.ok()) return true;
    const bool memory = resumed.status == CommandStatus::out_of_memory;
    end({memory ? RecordStatus::render_failed : RecordStatus::input_failed, RecordedCheckpoints::kCode, resumed.fault});
    return false;
  }

  void refuse_exception(const char* what) noexcept {
    result_.status = RecordStatus::render_failed;
    quietly([&] { refuse(RecordStatus::render_failed, "record.exception", std::string("failed: ") + what); });
  }

  bool refuse(RecordStatus status, const char* code, const std::string& text) {
    end({status, code, text});
    report(code, text);
    return false;
  }

  void report(const char* code, const std::string& text) const {
    if (options_.diagnostics) options_.diagnostics({Severity::error, code, settings_.str(), text});
  }

  void allocate() {
    for (const std::string& aov : request().aovs) {
      RenderBufferDescriptor buffer;
      buffer.dimensions = {size().x, size().y, 1};
      buffer.format = delegate_->GetDefaultAovDescriptor(aov).format;
      buffers_.try_emplace(aov, delegate_, settings_.append("buffer_" + aov), buffer);
    }
    if (!index_->Has(settings_)) scene_->Populate(index_);
  }

  Vec2i size() const { return {request().description.window().width(), request().description.window().height()}; }

  bool interrupted() {
    if ((options_.cancel && *options_.cancel) || delegate_->IsStopped()) result_.status = RecordStatus::interrupted;
    return result_.status == RecordStatus::interrupted;
  }

  bool sync() {
    const Phase phase(&phases_, "sync");
    const CancelWatch watch(options_.cancel, delegate_);
    if (!scene_->PopulateRest() || !index_->SyncAll())
      return refuse(RecordStatus::render_failed, "record.sync",
                    "the scene could not be synced: memory or threads ran out");
    // The scene's faults are known after this wait, which the watch ends. A delegate without the command has built it.
    const CommandResult built = delegate_->InvokeCommand("waitForScene", {});
    return built.ok() || built.status == CommandStatus::unknown ||
           refuse(RecordStatus::render_failed, "record.sync", "the scene could not be built: " + built.fault);
  }

  // A delegate refuses buffers that are too large and reports it. Nothing is rendered without them.
  bool have_buffers() {
    for (const auto& [aov, buffer] : buffers_) {
      const RenderBuffer* held = buffer.get();
      if (!held) return refuse(RecordStatus::render_failed, "record.memory", "memory ran out");
      if (Vec2i(held->GetWidth(), held->GetHeight()) != size())
        return refuse(RecordStatus::input_failed, "record.buffer",
                      "the render buffer of AOV '" + aov + "' cannot hold " + support::size_text(size().x, size().y) +
                          " pixels; lower the resolution or render a crop");
    }
    return true;
  }

  // A picture without its texture or light looks finished, so keep_going alone renders it. None is rendered without
  // what memory was refused for.
  bool scene_is_whole() {
    const Dictionary stats = delegate_->GetRenderStats();
    if (stats.empty()) return refuse(RecordStatus::render_failed, "record.memory", "memory ran out");
    const auto faults = static_cast<uint64_t>(number_in(stats, "scene.faultCount")) + options_.faults.size();
    const bool memory = number_in(stats, "scene.outOfMemory") != 0;
    if (faults == 0 || (options_.keep_going && !memory)) return true;
    return refuse(memory ? RecordStatus::render_failed : RecordStatus::input_failed, "record.scene",
                  std::to_string(faults) + (faults == 1 ? " fault" : " faults") +
                      " of the scene (see above): nothing is rendered" +
                      (memory ? "" : ". Correct the scene, or render without what is missing (keep_going)"));
  }

  RenderPassState pass_state() const {
    const RenderSettingsDescription& d = request().description;
    const Rect2i window = d.window();
    RenderPassState state;
    state.camera = d.camera;
    state.freeCamera = changed_camera();
    state.renderTags.clear();
    for (const Token& purpose : d.includedPurposes)
      state.renderTags.push_back(purpose == Token("default") ? Token("geometry") : purpose);
    // Buffers are as large as the data window; the display window is moved so that it starts at their corner.
    const Vec2f corner(static_cast<float>(window.minX), static_cast<float>(window.minY));
    state.framing.displayMin = -corner;
    state.framing.displayMax = Vec2f(static_cast<float>(d.width), static_cast<float>(d.height)) - corner;
    state.framing.dataWindow = {0, 0, window.width(), window.height()};
    state.framing.pixelAspectRatio = d.pixelAspectRatio;
    state.windowPolicy = d.windowPolicy;
    for (const auto& [aov, buffer] : buffers_) state.aovBindings.push_back({aov, buffer.get(), {}});
    return state;
  }

  /// The camera as the products change it; empty: as it is.
  std::optional<CameraDescription> changed_camera() const {
    const auto found = scene_->GetCameras().find(request().description.camera);
    if (found == scene_->GetCameras().end() || (request().motion_blur && request().depth_of_field)) return std::nullopt;
    CameraDescription camera = found->second;
    if (!request().motion_blur) camera.parameters["shutterOpen"] = camera.parameters["shutterClose"] = 0.0;
    if (!request().depth_of_field) camera.parameters["fStop"] = 0.0f, camera.parameters.erase("fStop:samples");
    return camera;
  }

  void render() {
    const Phase phase(&phases_, "render");
    started_ = Clock::now();
    std::unique_ptr<RenderPass> pass = delegate_->CreateRenderPass();
    if (!pass) {
      refuse(RecordStatus::render_failed, "record.pass", "the delegate made no render pass");
      return;
    }
    const RenderPassState state = pass_state();
    delegate_->Resume();  // a render that waits for its end would wait for that of a pause, too
    pass->Execute(state);
    double told = 0;
    checkpoints_.begin();
    shown_ = Clock::now();
    while (!pass->IsConverged() && !interrupted()) {
      pass->WaitForConvergence(0.02);
      pass->Execute(state);
      if (const double now = seconds_since(started_); options_.progress && now - told >= 0.1) {
        told = now;
        options_.progress(progress());
      }
      checkpoints_.write_if_due(request().description);
      show_if_due();
    }
    if (pass->GetState() != PassState::failed && !delegate_->IsStopped())
      checkpoints_.write_last(request().description);
    finish(pass);
    rendered_ = true;
  }

  // Faults of the delegate, and those of reading the scene.
  Dictionary with_faults(Dictionary stats) const {
    if (options_.faults.empty() || stats.empty()) return stats;
    std::string all = text_in(stats, "scene.faults");
    for (const std::string& fault : options_.faults) all += (all.empty() ? "" : "\n") + fault;
    stats["scene.faults"] = all;
    return stats;
  }

  // An interrupted render is stopped before its statistics are read, so that they agree with the pixels.
  void finish(std::unique_ptr<RenderPass>& pass) {
    std::shared_ptr<const void> stop;
    if (!pass->IsConverged() && interrupted()) {
      stop = delegate_->HoldStopped();
      if (const auto denoised = buffers_.find("denoised"); denoised != buffers_.end())
        denoised->second.get()->Resolve();  // denoises the samples so far
    }
    result_.stats = with_faults(delegate_->GetRenderStats());
    if (result_.stats.empty()) refuse(RecordStatus::render_failed, "record.memory", "memory ran out");
    if (pass->GetState() == PassState::failed) {
      const bool refused = number_in(result_.stats, "refused") != 0;
      const Value* error = support::find_in(result_.stats, "error");
      end({refused ? RecordStatus::input_failed : RecordStatus::render_failed, "record.render",
           error ? error->text_or({}) : std::string("the render failed")});
    } else if (result_.status == RecordStatus::done && result_.stats.contains("scene.faults")) {
      result_.out_of_memory = number_in(result_.stats, "scene.outOfMemory") != 0;
      end({RecordStatus::degraded, "record.scene", text_in(result_.stats, "scene.faults")});
    }
    if (options_.progress && pass->GetState() != PassState::failed) options_.progress(progress());
    pass.reset();
    warn_of_empty_pixels();
    warn_of_missed_target();
  }

  // An interrupted picture is marked incomplete anyway.
  void warn_of_empty_pixels() const {
    const auto empty = static_cast<uint64_t>(number_in(result_.stats, "pixelsWithoutSample"));
    if (empty == 0 || !succeeded() || !options_.diagnostics) return;
    const uint64_t all = static_cast<uint64_t>(size().x) * static_cast<uint64_t>(size().y);
    options_.diagnostics(
        {Severity::warning, "record.timeLimit", settings_.str(),
         "The time limit ended the render before every pixel had a sample: " + std::to_string(empty) + " of " +
             std::to_string(all) + " pixels have none, and AOV sampleCount is 0 there. " +
             (empty == all ? "What precedes the first sample took as long as the limit. " : "") +
             "Blocks of pixels without any sample are transparent "
             "(alpha 0); other such pixels show the sample in the upper left corner of their block. Raise the time "
             "limit, or render fewer pixels"});
  }

  void warn_of_missed_target() const {
    const auto message = result_.stats.find("target.message");
    if (message == result_.stats.end() || !succeeded() || !options_.diagnostics) return;
    options_.diagnostics({Severity::warning, "record.targetError", settings_.str(), message->second.text_or("")});
  }

  RecordProgress progress() const {
    const Dictionary stats = delegate_->GetRenderStats();
    RecordProgress p;
    const double fraction = number_in(stats, "fractionDone");
    p.fraction = (static_cast<double>(at_) + fraction) / static_cast<double>(options_.plan.pictures->size());
    p.seconds = seconds_since(started_);
    const double rays = number_in(stats, "rays.camera") + number_in(stats, "rays.bounce") +
                        number_in(stats, "rays.shadow") + number_in(stats, "rays.walk");
    const double rendering = number_in(stats, "totalClockTime");
    p.rays_per_second = rendering > 0 ? rays / rendering : 0;
    p.seconds_left = fraction > 0.005 ? rendering * (1 - fraction) / fraction : -1;
    if (stats.contains("denoise.fraction")) p.denoised = number_in(stats, "denoise.fraction");
    p.samples_done = static_cast<uint64_t>(number_in(stats, "numCompletedSamples"));
    p.samples_total = static_cast<uint64_t>(number_in(stats, "samplesTotal"));
    return p;
  }

  void collect_stats() {
    if (result_.stats.empty()) result_.stats = with_faults(delegate_->GetRenderStats());
    for (const auto& [key, value] : phases_) result_.stats[key] = value;
    checkpoints_.add_to(&result_.stats);
  }

  void add_names(ProductImage* image) {
    const bool has_numbers = std::any_of(request().aovs.begin(), request().aovs.end(), [](const std::string& name) {
      const AovInfo* aov = find_aov(name);
      return aov && (kNamedAovs & aov_bit(aov->aov)) != 0;
    });
    if (!has_numbers) return;
    const CommandResult named = delegate_->InvokeCommand("names", {});
    if (const auto names = named.value.get_or(std::shared_ptr<const Dictionary>()))
      image->names = *names, result_.stats["names"] = names;
  }

  /// The pixels of all buffers, by AOV: every one at once, because an interrupted render must not keep anyone waiting.
  using AllPixels = std::vector<std::pair<std::string, std::optional<MappedPixels>>>;
  AllPixels all_pixels() const {
    std::vector<RenderBuffer*> buffers;
    for (const auto& [aov, buffer] : buffers_) buffers.push_back(buffer.get());
    AllPixels all(buffers.size());
    size_t next = 0;
    for (const auto& [aov, buffer] : buffers_) all[next++].first = aov;
    tbb::task_arena arena;
    arena.execute([&] {
      tbb::parallel_for(size_t(0), buffers.size(), [&](size_t i) { all[i].second.emplace(buffers[i], size()); });
    });
    return all;
  }

  ProductImage image_of(const AllPixels& all, const Dictionary& stats) const {
    const RenderSettingsDescription& d = request().description;
    ProductImage image;
    for (const auto& [aov, mapped] : all)
      if (mapped && mapped->pixels.components > 0) image.aovs[aov] = mapped->pixels;
    image.framing.displayMax = {static_cast<float>(d.width), static_cast<float>(d.height)};
    image.framing.dataWindow = d.window();
    image.framing.pixelAspectRatio = d.pixelAspectRatio;
    image.metadata = ProductMetadata(*delegate_, stats, request().description.camera);
    image.metadata.insert(options_.metadata.begin(), options_.metadata.end());
    return image;
  }

  void show_if_due() {
    if (options_.live_seconds <= 0 || seconds_since(shown_) < options_.live_seconds) return;
    const AllPixels all = all_pixels();
    ProductImage image = image_of(all, delegate_->GetRenderStats());
    image.incomplete = true;
    const auto warn = [&](const Diagnostic& diagnostic) {
      if (diagnostic.severity == Severity::error && options_.diagnostics)
        options_.diagnostics({Severity::warning, diagnostic.code, diagnostic.where,
                              diagnostic.text + ". The render goes on, and writes its files at its end"});
    };
    if (write_planned(request().files, image, warn).size() != request().files.size()) options_.live_seconds = 0;
    shown_ = Clock::now();
  }

  void write() {
    if (options_.writing) options_.writing();
    const Phase phase(&result_.stats, "write");
    const AllPixels all = all_pixels();
    ProductImage image = image_of(all, result_.stats);
    for (const auto& [aov, mapped] : all)
      if (!image.aovs.contains(aov) && result_.status != RecordStatus::interrupted)
        refuse(RecordStatus::render_failed, "record.buffer", "AOV '" + aov + "' has no pixels");
    if (result_.status != RecordStatus::render_failed) write_products(&image);
  }

  void write_products(ProductImage* image) {
    const RenderSettingsDescription& d = request().description;
    image->incomplete = result_.status == RecordStatus::interrupted;
    add_names(image);
    if (options_.picture) options_.picture(*image);
    const auto written = write_planned(request().files, *image, options_.diagnostics);
    result_.written.insert(result_.written.end(), written.begin(), written.end());
    const bool interrupted = result_.status == RecordStatus::interrupted;
    const auto fail = [&](const char* code, std::string text) {
      if (!interrupted) end({RecordStatus::output_failed, code, std::move(text)});
    };
    if (written.size() != d.products.size()) fail("record.product", "not all files could be written");
    if (const auto error = result_.stats.find("denoise.error"); error != result_.stats.end()) {
      const std::string text =
          "The picture could not be denoised: " + error->second.text_or("") + ". Files show it as it was rendered.";
      report("record.denoise", text);
      fail("record.denoise", text);
    }
  }

  RenderIndex* index_;
  RetainedSceneDelegate* scene_;
  RenderDelegate* delegate_;
  Path settings_;
  RecordOptions options_;
  size_t at_ = 0;  // the picture of the plan that is recorded
  RecordedCheckpoints checkpoints_;
  std::map<std::string, OwnBuffer> buffers_;  // by AOV
  Clock::time_point started_, shown_;         // shown_: the last files of `live_seconds`
  bool rendered_ = false;
  Dictionary phases_;
  RecordResult result_;
};

}  // namespace

RecordResult RecordFrame(RenderIndex* index, RetainedSceneDelegate* scene, const Path& settings,
                         const RecordOptions& options) {
  const FloatEnvironment environment;
  return Recording(index, scene, settings, options).run();
}

std::optional<Vec2i> PictureSize(const std::string& file) {
  try {
    return whole_image_size(file);
  } catch (const std::exception&) {  // memory was refused
    return {};
  }
}

}  // namespace alabaster::hd::host
