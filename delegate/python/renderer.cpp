#include <algorithm>

#include "delegate/python/objects.h"

namespace alabaster::python {
namespace {

constexpr double kTellSeconds = 0.1;  // between calls of a progress callback, and looks for Ctrl-C

struct Format {
  const char* name;  // of the buffer protocol
  Py_ssize_t bytes, components;
};
Format format_of(int32_t format) {
  switch (format) {
    case ALABASTER_UNORM8:
      return {"B", 1, 1};
    case ALABASTER_UNORM8_3:
      return {"B", 1, 3};
    case ALABASTER_UNORM8_4:
      return {"B", 1, 4};
    case ALABASTER_HALF:
      return {"e", 2, 1};
    case ALABASTER_HALF_3:
      return {"e", 2, 3};
    case ALABASTER_HALF_4:
      return {"e", 2, 4};
    case ALABASTER_FLOAT32_2:
      return {"f", 4, 2};
    case ALABASTER_FLOAT32_3:
      return {"f", 4, 3};
    case ALABASTER_FLOAT32_4:
      return {"f", 4, 4};
    case ALABASTER_INT32:
      return {"i", 4, 1};
    default:
      return {"f", 4, 1};
  }
}

}  // namespace

void Messages::hear(void* user, const AlabasterDiagnostic* diagnostic) {
  auto& messages = *static_cast<Messages*>(user);
  const std::lock_guard lock(messages.mutex_);
  messages.queue_.push_back({diagnostic->severity, diagnostic->code, diagnostic->where, diagnostic->text});
}

void Messages::deliver() {
  std::vector<Message> told;
  {
    const std::lock_guard lock(mutex_);
    told.swap(queue_);
  }
  constexpr const char* kSeverities[] = {"info", "warning", "error"};
  for (const Message& m : told) {
    if (!listener_.is_none())
      listener_(kSeverities[std::clamp(m.severity, 0, 2)], m.code, m.where, m.text);
    else
      py::module_::import("logging")
          .attr("getLogger")("alabaster")
          .attr("log")(20 + 10 * m.severity, "%s: %s", m.where, m.text);
  }
}

Engine::~Engine() {
  drop(delegate);
}

py::dict progress_of(const AlabasterProgress& progress) {
  py::dict told;
  told["fraction"] = progress.fraction;
  told["seconds"] = progress.seconds;
  told["samples_done"] = progress.samples_done;
  told["samples_total"] = progress.samples_total;
  return told;
}

// Pixels -------------------------------------------------------------------------------------------
Pixels::Pixels(std::shared_ptr<Engine> engine, const door::Buffer& buffer) : engine_(std::move(engine)) {
  const py::gil_scoped_release unlocked;
  held_ = std::make_unique<door::Pixels>(buffer);
}
Pixels::~Pixels() {
  drop(held_);
}

py::buffer_info Pixels::info() const {
  const AlabasterPixels& raw = held_->get();
  const auto [name, bytes, components] = format_of(raw.format);
  const Py_ssize_t row = raw.width * components * bytes;
  // Rows lie bottom-up; the array begins with the uppermost.
  auto* top = static_cast<char*>(const_cast<void*>(raw.data)) + (raw.height - 1) * row;
  if (components == 1) return {top, bytes, name, 2, {raw.height, raw.width}, {-row, bytes}, true};
  return {top,
          bytes,
          name,
          3,
          {Py_ssize_t(raw.height), Py_ssize_t(raw.width), components},
          {-row, components * bytes, bytes},
          true};
}

// Renders ------------------------------------------------------------------------------------------
AlabasterFrame FrameOptions::pass(AlabasterCamera* held) const {
  auto frame = door::sized<AlabasterFrame>();
  frame.settings = door::or_null(settings);
  frame.camera = door::or_null(camera);
  frame.width = width, frame.height = height;
  frame.window = window;
  frame.pixel_aspect = pixel_aspect;
  if (free_camera) *held = free_camera->pass(), frame.free_camera = held;
  frame.render_tags = render_tags.pass();
  frame.roots = roots.pass(), frame.excluded = excluded.pass();
  return frame;
}

Render::Render(std::shared_ptr<Engine> engine, FrameOptions options)
    : engine_(std::move(engine)), options_(std::move(options)) {
  const py::gil_scoped_release unlocked;
  pass_ = door::make_pass(engine_->delegate);
}
Render::~Render() {
  drop(pass_);
  drop(buffers_);
}

void Render::update(const py::kwargs& changes) {
  options_.change(changes);
  auto camera = door::sized<AlabasterCamera>();
  AlabasterFrame frame = options_.pass(&camera);
  int32_t width = 0, height = 0;
  std::vector<AlabasterBinding> bindings;
  run(engine_->messages, [&](const AlabasterApi& api) {
    AlabasterDelegate* delegate = engine_->delegate.get();
    if (const AlabasterStatus status = api.frame_size(delegate, &frame, &width, &height)) return status;
    for (size_t i = 0; i < options_.aovs.size(); ++i) {
      int32_t format = ALABASTER_FORMAT_NONE;
      const char* aov = options_.aovs[i].c_str();
      if (const AlabasterStatus status = api.aov_format(delegate, aov, &format)) return status;
      AlabasterBuffer* made = nullptr;
      const AlabasterStatus status = i < buffers_.size() ? api.buffer_resize(buffers_[i].get(), width, height, format)
                                                         : api.buffer_create(delegate, width, height, format, &made);
      if (status != ALABASTER_OK) return status;
      if (made) buffers_.emplace_back(made);
      bindings.push_back({aov, buffers_[i].get()});
    }
    frame.bindings = bindings.data(), frame.binding_count = bindings.size();
    if (const AlabasterStatus status = api.restart(delegate)) return status;
    return api.pass_start(pass_.get(), &frame);
  });
}

bool Render::wait(const std::optional<double>& seconds, const py::object& progress) {
  const double limit = seconds.value_or(1e300);
  int32_t over = 0;
  double waited = 0;
  do {  // once in any case: it takes up what has been built
    const double slice = std::clamp(limit - waited, 0.0, kTellSeconds);
    waited += kTellSeconds;
    run(engine_->messages, [&](const AlabasterApi& api) { return api.pass_wait(pass_.get(), slice, &over); });
    if (PyErr_CheckSignals() != 0) {
      cancel();
      throw py::error_already_set();
    }
    if (progress.is_none()) continue;
    auto now = door::sized<AlabasterProgress>();
    door::check(door::api().progress(engine_->delegate.get(), &now));
    const py::object answer = progress(progress_of(now));
    if (!answer.is_none() && !answer.cast<bool>() && over == 0) {
      cancel();
      throw door::Error(ALABASTER_INTERRUPTED, "the render was cancelled");
    }
  } while (over == 0 && waited < limit);
  return over != 0;
}

std::string Render::state() const {
  constexpr const char* kStates[] = {"idle", "preparing", "rendering", "paused", "stopped", "converged", "failed"};
  int32_t state = 0;
  door::check(door::api().pass_state(pass_.get(), &state));
  return kStates[state];
}

void Render::cancel() {
  run(engine_->messages, [&](const AlabasterApi& api) { return api.stop(engine_->delegate.get()); });
}

const door::Buffer& Render::buffer(const std::string& aov) const {
  const auto found = std::find(options_.aovs.begin(), options_.aovs.end(), aov);
  const auto index = size_t(found - options_.aovs.begin());
  if (index >= buffers_.size()) throw py::key_error("AOV '" + aov + "' is not rendered: name it in aovs");
  return buffers_[index];
}

std::unique_ptr<Pixels> Render::pixels(const std::string& aov) const {
  return std::make_unique<Pixels>(engine_, buffer(aov));
}

namespace {

py::buffer_info contiguous(const py::buffer& into) {
  py::buffer_info info = into.request(true);
  Py_ssize_t stride = info.itemsize;
  for (Py_ssize_t axis = info.ndim; axis-- > 0; stride *= info.shape[size_t(axis)])
    if (info.strides[size_t(axis)] != stride) throw py::value_error("the array is not contiguous");
  return info;
}

/// The format of an array of (height, width) or (height, width, components).
int32_t format_of(const py::buffer_info& info) {
  const Py_ssize_t components = info.ndim == 3 ? info.shape[2] : 1;
  for (int32_t format = ALABASTER_UNORM8; format <= ALABASTER_INT32; ++format)
    if (const Format known = format_of(format);
        info.ndim >= 2 && info.ndim <= 3 && info.format == known.name && components == known.components)
      return format;
  throw py::value_error(
      "pixels are an array (height, width) or (height, width, components) of float32, float16 or uint8");
}

}  // namespace

void Render::read(const std::string& aov, const py::buffer& into, bool top_down) const {
  const py::buffer_info info = contiguous(into);
  const door::Buffer& held = buffer(aov);
  run(engine_->messages, [&](const AlabasterApi& api) {
    return api.buffer_read(held.get(), info.ptr, size_t(info.size * info.itemsize), top_down);
  });
}

bool Render::show(const std::string& aov, const py::buffer& into, const py::object& display, bool top_down) {
  const Display* converts = display.is_none() ? nullptr : &display.cast<const Display&>();
  const py::buffer_info info = contiguous(into);
  const double exposure = converts ? converts->exposure() : 0;
  auto memory = door::sized<AlabasterMemory>();
  memory.format = format_of(info);
  memory.pixels = info.ptr;
  memory.height = int32_t(info.shape[0]), memory.width = int32_t(info.shape[1]);
  memory.row_bytes = size_t(info.strides[0]);
  memory.y_up = !top_down;
  memory.display = converts ? converts->handle().get() : nullptr;
  Shown& known = shown_[aov];
  if (known.into.is(into) && known.display.is(display) && known.exposure == exposure &&
      known.memory.y_up == memory.y_up && known.memory.width == memory.width && known.memory.height == memory.height)
    memory.shown = known.memory.shown;
  const door::Buffer& held = buffer(aov);
  bool same_size = true;
  run(engine_->messages, [&](const AlabasterApi& api) {
    const int32_t width = memory.width, height = memory.height;
    const AlabasterStatus status = api.buffer_show(held.get(), &memory);
    same_size = memory.width == width && memory.height == height;
    return same_size ? status : int32_t(ALABASTER_OK);
  });
  if (!same_size) return false;
  known = {into, display, exposure, memory};
  return true;
}

// Displays -----------------------------------------------------------------------------------------
Display::Display(const py::object& color_config, const std::string& display, const std::string& view,
                 const std::string& look, double exposure)
    : exposure_(exposure) {
  const std::string config = color_config.is_none() ? "" : py::str(color_config).cast<std::string>();
  auto options = door::sized<AlabasterDisplayOptions>();
  options.color_config = door::or_null(config);
  options.display = door::or_null(display), options.view = door::or_null(view), options.look = door::or_null(look);
  options.exposure = exposure;
  const py::gil_scoped_release unlocked;
  AlabasterDisplay* made = nullptr;
  door::check(door::api().display_create(&options, &made));
  held_.reset(made);
}

void Display::set_exposure(double stops) {
  door::check(door::api().display_set_exposure(held_.get(), stops));
  exposure_ = stops;
}

}  // namespace alabaster::python
