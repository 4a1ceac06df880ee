#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "delegate/python/objects.h"

namespace alabaster::python {
namespace {

constexpr double kTellSeconds = 0.1;  // between calls of a progress callback, and looks for Ctrl-C

struct Format {
  const char* name;  // of the buffer protocol
  Py_ssize_t bytes, components;
};
/// By the number of the format: ALABASTER_FORMAT_NONE, then ALABASTER_UNORM8 and so on.
constexpr Format kFormats[] = {{"f", 4, 1}, {"B", 1, 1}, {"B", 1, 3}, {"B", 1, 4}, {"e", 2, 1}, {"e", 2, 3},
                               {"e", 2, 4}, {"f", 4, 1}, {"f", 4, 2}, {"f", 4, 3}, {"f", 4, 4}, {"i", 4, 1}};
static_assert(std::size(kFormats) == ALABASTER_INT32 + 1);

}  // namespace

void Messages::hear(void* user, const AlabasterDiagnostic* diagnostic) {
  auto& messages = *static_cast<Messages*>(user);
  const std::lock_guard lock(messages.mutex_);
  messages.queue_.push_back({diagnostic->severity, diagnostic->code, diagnostic->where, diagnostic->text});
}

std::optional<Messages::Message> Messages::next() {
  const std::lock_guard lock(mutex_);
  if (queue_.empty()) return std::nullopt;
  Message first = std::move(queue_.front());
  queue_.pop_front();
  return first;
}

// One at a time: a listener that throws leaves the rest to the next call.
void Messages::deliver() {
  constexpr const char* kSeverities[] = {"info", "warning", "error"};
  while (const std::optional<Message> m = next()) {
    const py::str where = message_to_python(m->where), what = message_to_python(m->text);
    with_host_code([&] {
      if (!listener_.is_none())
        listener_(kSeverities[std::clamp(m->severity, 0, 2)], message_to_python(m->code), where, what);
      else
        py::module_::import("logging")
            .attr("getLogger")("hdalabaster")
            .attr("log")(20 + 10 * m->severity, "%s: %s", where, what);
    });
  }
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
Pixels::Pixels(std::shared_ptr<Engine> engine, std::unique_ptr<c_api::Pixels> held)
    : engine_(std::move(engine)), report_(engine_->messages.listener()), held_(std::move(held)) {}
Pixels::~Pixels() {
  drop(held_);
}

py::buffer_info Pixels::info() const {
  const AlabasterPixels& raw = held_->get();
  const auto [name, bytes, components] = kFormats[raw.format];
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
AlabasterFrame FrameOptions::pass(std::vector<AlabasterParameter>* held) const {
  auto frame = c_api::sized<AlabasterFrame>();
  frame.settings = c_api::or_null(settings);
  frame.camera = c_api::or_null(camera);
  frame.width = width, frame.height = height;
  frame.window = window;
  frame.pixel_aspect = pixel_aspect;
  *held = c_api::pass(free_camera);
  frame.free_camera = held->data(), frame.free_camera_count = held->size();
  frame.render_tags = render_tags.pass();
  frame.roots = roots.pass(), frame.excluded = excluded.pass();
  return frame;
}

FrameOptions changed(FrameOptions options, const FrameChanges& changes) {
  for (const auto& change : changes) change(options);
  return options;
}

Render::Render(std::shared_ptr<Engine> engine) : engine_(std::move(engine)), report_(engine_->messages.listener()) {
  engine_->run([&](const AlabasterApi&, AlabasterDelegate*, Unlocked&) {
    pass_ = c_api::make_pass(engine_->delegate);
    return int32_t(ALABASTER_OK);
  });
}
Render::~Render() {
  drop(pass_);
  drop(buffers_);
}

void Render::update(const FrameChanges& changes) {
  engine_->run([&](const AlabasterApi& api, AlabasterDelegate*, Unlocked&) {
    const std::lock_guard turn(engine_->turn);
    engine_->refuse_while_recording();
    return start(api, changed(options_, changes));
  });
}

namespace {

AlabasterStatus formats_of(const AlabasterApi& api, AlabasterDelegate* delegate, const std::vector<std::string>& aovs,
                           std::vector<int32_t>* formats) {
  for (const std::string& aov : aovs) {
    int32_t format = ALABASTER_FORMAT_NONE;
    if (const AlabasterStatus status = api.aov_format(delegate, aov.c_str(), &format)) return status;
    if (format == ALABASTER_FORMAT_NONE) throw c_api::Error(ALABASTER_NOT_FOUND, api.last_error());
    formats->push_back(format);
  }
  return ALABASTER_OK;
}

}  // namespace

// A failure leaves the options of before. Each call has a frame of its own, since it takes what the frame lends.
AlabasterStatus Render::start(const AlabasterApi& api, const FrameOptions& next) {
  AlabasterDelegate* delegate = engine_->delegate.get();
  std::vector<int32_t> formats;
  if (const AlabasterStatus status = formats_of(api, delegate, next.aovs, &formats)) return status;
  std::vector<AlabasterParameter> camera;
  AlabasterFrame frame = next.pass(&camera);
  int32_t width = 0, height = 0;
  if (const AlabasterStatus status = api.frame_size(delegate, &frame, &width, &height)) return status;
  std::vector<SharedBuffer> buffers = buffers_;
  std::vector<AlabasterBinding> bindings;
  for (size_t i = 0; i < formats.size(); ++i) {
    AlabasterBuffer* made = nullptr;
    const AlabasterStatus status = i < buffers.size() ? api.buffer_resize(buffers[i]->get(), width, height, formats[i])
                                                      : api.buffer_create(delegate, width, height, formats[i], &made);
    if (status != ALABASTER_OK) return status;
    if (made) buffers.push_back(std::make_shared<c_api::Buffer>(made));
    bindings.push_back({next.aovs[i].c_str(), buffers[i]->get()});
  }
  if (const AlabasterStatus status = api.restart(delegate)) return status;
  frame = next.pass(&camera);
  frame.bindings = bindings.data(), frame.binding_count = bindings.size();
  const AlabasterStatus status = api.pass_start(pass_.get(), &frame);
  if (status != ALABASTER_OK) return status;
  const std::lock_guard lock(mutex_);
  options_ = next;
  buffers_ = std::move(buffers);
  return ALABASTER_OK;
}

namespace {

/// The most that a wait may last; None: without limit.
double limit_of(const py::object& seconds) {
  if (seconds.is_none()) return std::numeric_limits<double>::infinity();
  const double limit = number(seconds, "seconds");
  if (std::isnan(limit)) throw py::value_error("seconds is no number");
  return limit;
}

}  // namespace

// Ctrl-C comes in a listener of reports, in the progress callback or between them. None of the listener's further
// errors takes its place.
bool Render::wait(const py::object& seconds, const py::object& progress) {
  try {
    return wait_for(seconds, progress);
  } catch (py::error_already_set& error) {
    if (PyErr_CheckSignals() == 0) {
      if (error.matches(PyExc_KeyboardInterrupt)) stop_quietly();
      throw;
    }
    const py::error_already_set interrupt;
    stop_quietly();
    throw interrupt;
  }
}

void Render::stop_quietly() {
  const Unlocked unlocked;
  static_cast<void>(c_api::api().stop(engine_->delegate.get()));
}

bool Render::wait_for(const py::object& seconds, const py::object& progress) {
  if (!progress.is_none() && PyCallable_Check(progress.ptr()) == 0)
    throw wrong_type("progress", "a function", progress);
  const double limit = limit_of(seconds);
  int32_t over = 0;
  double waited = 0;
  do {  // once in any case: it takes up what has been built
    const double slice = std::clamp(limit - waited, 0.0, kTellSeconds);
    waited += kTellSeconds;
    auto now = c_api::sized<AlabasterProgress>();
    engine_->run([&](const AlabasterApi& api, AlabasterDelegate* delegate, Unlocked&) {
      const AlabasterStatus status = api.pass_wait(pass_.get(), slice, &over);
      return status == ALABASTER_OK ? api.progress(delegate, &now) : status;
    });
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (progress.is_none()) continue;
    const bool continues = with_host_code([&] {
      const py::object answer = progress(progress_of(now));
      return answer.is_none() || flag(answer, "what progress returns");
    });
    if (!continues && over == 0) {
      cancel();
      throw c_api::Error(ALABASTER_INTERRUPTED, "the render was cancelled");
    }
  } while (over == 0 && waited < limit);
  return over != 0;
}

std::string Render::state() {
  constexpr const char* kStates[] = {"idle", "preparing", "rendering", "paused", "stopped", "converged", "failed"};
  int32_t state = 0;
  engine_->run([&](const AlabasterApi& api, AlabasterDelegate*, Unlocked&) {
    take_up(api);
    return api.pass_state(pass_.get(), &state);
  });
  return kStates[state];
}

void Render::cancel() {
  engine_->run([](const AlabasterApi& api, AlabasterDelegate* delegate, Unlocked&) { return api.stop(delegate); });
}

// A failed render is told by wait and state.
void Render::take_up(const AlabasterApi& api) const {
  int32_t over = 0;
  static_cast<void>(api.pass_wait(pass_.get(), 0, &over));
}

Render::SharedBuffer Render::newest(const AlabasterApi& api, const std::string& aov) {
  take_up(api);
  const std::lock_guard lock(mutex_);
  const auto found = std::find(options_.aovs.begin(), options_.aovs.end(), aov);
  const auto index = size_t(found - options_.aovs.begin());
  if (index >= buffers_.size() || found == options_.aovs.end())
    throw py::key_error("AOV '" + aov + "' is not rendered: name it in aovs");
  return buffers_[index];
}

std::unique_ptr<Pixels> Render::pixels(const Text& aov) {
  std::unique_ptr<c_api::Pixels> held;
  engine_->run([&](const AlabasterApi& api, AlabasterDelegate*, Unlocked&) {
    held = std::make_unique<c_api::Pixels>(*newest(api, aov));
    return int32_t(ALABASTER_OK);
  });
  return make_object<Pixels>(engine_, std::move(held));
}

namespace {

py::buffer_info writable(const py::buffer& into) {
  try {
    return into.request(true);
  } catch (py::error_already_set& error) {
    if (!error.matches(PyExc_BufferError)) throw;
    throw py::value_error("the array cannot be written to, or its elements lie apart");
  }
}

/// The format without the order of the machine.
std::string kind_of(const py::buffer_info& info) {
  return info.format.substr(info.format.find_first_of("@=<") == 0 ? 1 : 0);
}

/// Memory that bytes may be written to: never that of an array of objects, which are pointers.
py::buffer_info contiguous(const py::buffer& into) {
  py::buffer_info info = writable(into);
  const std::string kind = kind_of(info);
  if (kind.size() != 1 || !std::strchr("bBhHiIlLqQefdc", kind[0]))
    throw py::value_error("pixels cannot be written to an array of type '" + info.format + "'; use float32 or uint8");
  Py_ssize_t stride = info.itemsize;
  for (Py_ssize_t axis = info.ndim; axis-- > 0; stride *= info.shape[size_t(axis)])
    if (info.strides[size_t(axis)] != stride) throw py::value_error("the array is not contiguous");
  return info;
}

/// Memory of the host for pixels: an array of (height, width) or (height, width, components).
AlabasterMemory memory_of(const py::buffer_info& info) {
  constexpr Py_ssize_t kMost = std::numeric_limits<int32_t>::max();
  auto memory = c_api::sized<AlabasterMemory>();
  const Py_ssize_t components = info.ndim == 3 ? info.shape[2] : 1;
  for (int32_t format = ALABASTER_UNORM8; format <= ALABASTER_INT32; ++format)
    if (const Format known = kFormats[format]; info.ndim >= 2 && info.ndim <= 3 && info.format == known.name &&
                                               info.itemsize == known.bytes && components == known.components)
      memory.format = format;
  if (memory.format == ALABASTER_FORMAT_NONE || info.shape[0] > kMost || info.shape[1] > kMost)
    throw py::value_error(
        "pixels are an array (height, width) or (height, width, components) of float32, float16 or uint8");
  memory.pixels = info.ptr;
  memory.height = int32_t(info.shape[0]), memory.width = int32_t(info.shape[1]);
  memory.row_bytes = size_t(info.strides[0]);
  return memory;
}

}  // namespace

namespace {

std::string type_and_shape(const std::string& kind, Py_ssize_t bytes, const std::vector<Py_ssize_t>& shape) {
  std::string axes;
  for (const Py_ssize_t length : shape) axes += (axes.empty() ? "" : ", ") + std::to_string(length);
  return "of type '" + kind + "' (" + std::to_string(8 * bytes) + " bits) and shape (" + axes + ")";
}

/// The array takes these pixels as they are: it has their type and shape, or one axis with as many numbers.
void check_takes(const py::buffer_info& info, const AlabasterPixels& pixels) {
  const auto [name, bytes, components] = kFormats[pixels.format];
  std::vector<Py_ssize_t> shape = {pixels.height, pixels.width};
  if (components > 1) shape.push_back(components);
  const bool is_flat = info.ndim == 1 && info.size == shape[0] * shape[1] * components;
  if (kind_of(info) == name && info.itemsize == bytes && (is_flat || info.shape == shape)) return;
  throw c_api::Error(ALABASTER_INVALID_ARGUMENT, "the pixels are " + type_and_shape(name, bytes, shape) +
                                                     ", and the array is " +
                                                     type_and_shape(info.format, info.itemsize, info.shape));
}

}  // namespace

void Render::read(const Text& aov, const py::buffer& into, bool top_down) {
  const py::buffer_info info = contiguous(into);
  engine_->run([&](const AlabasterApi& api, AlabasterDelegate*, Unlocked&) {
    const SharedBuffer held = newest(api, aov);
    check_takes(info, c_api::Pixels(*held).get());
    return api.buffer_read(held->get(), info.ptr, size_t(info.size * info.itemsize), top_down);
  });
}

bool Render::Shown::is_of(const Shown& other) const {
  const AlabasterMemory &a = memory, &b = other.memory;
  return into.is(other.into) && display.is(other.display) && exposure == other.exposure && a.pixels == b.pixels &&
         a.format == b.format && a.y_up == b.y_up && a.width == b.width && a.height == b.height;
}

bool Render::show(const Text& aov, const py::buffer& into, const py::object& display, bool top_down) {
  const Display* converts =
      display.is_none() ? nullptr : &object_of<Display>(display, "display", "an hdalabaster.Display or None");
  const py::buffer_info info = contiguous(into);
  Shown now{into, display, converts ? converts->exposure() : 0, memory_of(info)};
  now.memory.y_up = !top_down;
  now.memory.display = converts ? converts->handle().get() : nullptr;
  Shown before;  // ends when Python's lock is held
  bool same_size = true;
  engine_->run([&](const AlabasterApi& api, AlabasterDelegate* delegate, Unlocked&) {
    const SharedBuffer held = newest(api, aov);
    int32_t format = ALABASTER_FORMAT_NONE;
    c_api::check(api.aov_format(delegate, aov.c_str(), &format));
    if (now.memory.format == ALABASTER_INT32 && format != ALABASTER_INT32)
      throw c_api::Error(ALABASTER_INVALID_ARGUMENT,
                         "an array of int32 shows no fractions, which AOV '" + aov + "' has: use float32");
    const std::lock_guard lock(showing_);
    Shown& known = shown_[aov];
    if (known.is_of(now)) now.memory.shown = known.memory.shown;
    const int32_t width = now.memory.width, height = now.memory.height;
    const AlabasterStatus status = api.buffer_show(held->get(), &now.memory);
    same_size = now.memory.width == width && now.memory.height == height;
    if (same_size && status == ALABASTER_OK) before = std::exchange(known, std::move(now));
    return same_size ? status : int32_t(ALABASTER_OK);
  });
  return same_size;
}

namespace {

struct Hit {
  std::string path;
  int32_t instance_id, face, x, y;
  std::vector<std::pair<std::string, int32_t>> instances;
};
void keep_hit(void* user, const AlabasterPick* pick) {
  Hit hit = {pick->path, pick->instance_id, pick->face, pick->x, pick->y, {}};
  for (size_t i = 0; i < pick->instance_count; ++i)
    hit.instances.emplace_back(pick->instances[i].instancer, pick->instances[i].index);
  static_cast<std::vector<Hit>*>(user)->push_back(std::move(hit));
}

}  // namespace

py::list Render::pick(const py::object& window) {
  const AlabasterRect rect = rect_of(window, "window");
  std::vector<Hit> hits;
  engine_->run([&](const AlabasterApi& api, AlabasterDelegate*, Unlocked&) {
    take_up(api);
    return api.pick(pass_.get(), &rect, &keep_hit, &hits);
  });
  py::list told;
  for (const Hit& hit : hits) {
    py::list instances;
    for (const auto& [instancer, index] : hit.instances)
      instances.append(py::make_tuple(name_to_python(instancer), index));
    py::dict entry;
    entry["path"] = name_to_python(hit.path), entry["face"] = hit.face;
    entry["instance_id"] = hit.instance_id, entry["instances"] = instances;
    entry["x"] = hit.x, entry["y"] = hit.y;
    told.append(entry);
  }
  return told;
}

// Displays -----------------------------------------------------------------------------------------
Display::Display(const py::object& color_config, const std::string& display, const std::string& view,
                 const std::string& look, double exposure)
    : exposure_(exposure) {
  const std::string config = color_config.is_none() ? std::string() : file_name(color_config, "color_config");
  auto options = c_api::sized<AlabasterDisplayOptions>();
  options.color_config = c_api::or_null(config);
  options.display = c_api::or_null(display), options.view = c_api::or_null(view), options.look = c_api::or_null(look);
  options.exposure = exposure;
  const Unlocked unlocked;
  AlabasterDisplay* made = nullptr;
  c_api::check(c_api::api().display_create(&options, &made));
  held_.reset(made);
}

void Display::set_exposure(double stops) {
  {
    const Unlocked unlocked;
    c_api::check(c_api::api().display_set_exposure(held_.get(), stops));
  }
  exposure_ = stops;
}

}  // namespace alabaster::python
