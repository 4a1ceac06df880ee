// The module's classes. Internal to this room.
//
// Every call into the library releases Python's lock. The library's threads never take it: their reports, and the
// memory that they give back, wait for the next call.
#pragma once

#include <map>
#include <mutex>
#include <optional>

#include "delegate/python/structs.h"

namespace alabaster::python {

/// Reports of the library, until Python is told.
class Messages {
 public:
  /// `listener`: called with severity, code, where and text; None logs them under the name "alabaster".
  explicit Messages(py::object listener) : listener_(std::move(listener)) {}
  static void hear(void* user, const AlabasterDiagnostic* diagnostic);
  void deliver();

 private:
  struct Message {
    int32_t severity;
    std::string code, where, text;
  };
  py::object listener_;
  std::mutex mutex_;
  std::vector<Message> queue_;
};

/// Runs `call`, a function of the C door, without Python's lock; then tells what was reported, and throws if it failed.
template <class Call>
void run(Messages& messages, const Call& call) {
  std::optional<door::Error> error;
  {
    const py::gil_scoped_release unlocked;
    const AlabasterStatus status = call(door::api());
    if (status != ALABASTER_OK) error.emplace(status, door::api().last_error());
  }
  free_returned();
  messages.deliver();
  if (error) throw *error;
}

/// Calls visit(name, value), under Python's lock, for what `call(api, AlabasterVisit, void*)` tells.
template <class Call, class Visit>
void ask(Messages& messages, const Call& call, Visit visit) {
  const AlabasterVisit tell = [](void* user, const char* name, const AlabasterValue* value) {
    const py::gil_scoped_acquire locked;
    (*static_cast<Visit*>(user))(name, *value);
  };
  run(messages, [&](const AlabasterApi& api) { return call(api, tell, static_cast<void*>(&visit)); });
}

/// Destroys without Python's lock: the library may have to wait for a thread that wants it.
template <class Handle>
void drop(Handle& handle) {
  const py::gil_scoped_release unlocked;
  const Handle gone = std::move(handle);
}

class Scene {
 public:
  explicit Scene(py::object report);
  ~Scene();
  const door::Scene& handle() const { return handle_; }
  Messages& messages() { return messages_; }

  py::dict load(const py::object& file, const py::dict& options);
  void write(const py::object& file, const py::object& overrides, const py::kwargs& frame);
  py::dict prims();
  void set_mesh(const std::string& path, const py::object& points, const py::object& indices, const py::object& counts,
                const py::dict& options);
  void set_primvar(const std::string& mesh, const std::string& name, const py::object& values,
                   const std::string& interpolation);
  void set_instancer(const std::string& path, const py::dict& prototypes, const py::dict& options);
  void set_instance_values(const std::string& path, size_t first, const py::dict& options);
  void set_material(const std::string& path, const py::object& nodes, const std::string& displacement,
                    const py::dict& parameters);
  void set_light(const std::string& path, const std::string& type, const py::object& transform, bool visible,
                 const py::dict& parameters);
  void set_camera(const std::string& path, const py::dict& options);
  void set_render_settings(const std::string& path, const py::dict& options);
  /// `call(api, scene)`
  template <class Call>
  void run(const Call& call) {
    python::run(messages_, [&](const AlabasterApi& api) { return call(api, handle_.get()); });
  }

 private:
  Messages messages_;
  door::Scene handle_;
};

struct Primvar {
  py::object values;
  std::string interpolation;
  py::object indices;
  std::string role;
  py::object motion = py::none();
};

/// The renderer's handles, shared by the renders that it made.
struct Engine {
  explicit Engine(py::object report) : messages(std::move(report)) {}
  ~Engine();
  Messages messages;
  door::Delegate delegate;
};

class Pixels {
 public:
  Pixels(std::shared_ptr<Engine> engine, const door::Buffer& buffer);
  ~Pixels();
  py::buffer_info info() const;
  const AlabasterPixels& get() const { return held_->get(); }

 private:
  std::shared_ptr<Engine> engine_;
  std::unique_ptr<door::Pixels> held_;
};

struct FrameOptions {
  std::vector<std::string> aovs = {"color"};
  int width = 0, height = 0;
  std::string camera, settings;
  std::optional<Camera> free_camera;  // in the place of `camera`
  Tokens render_tags, roots, excluded;
  AlabasterRect window{};
  double pixel_aspect = 0;

  /// Changes what is given; other names are an error.
  void change(const py::kwargs& given);
  /// For one call, to which it gives what is lent. The frame points at `held`.
  AlabasterFrame pass(AlabasterCamera* held) const;
};

class Display {
 public:
  Display(const py::object& color_config, const std::string& display, const std::string& view, const std::string& look,
          double exposure);
  double exposure() const { return exposure_; }
  void set_exposure(double stops);
  const door::Display& handle() const { return held_; }

 private:
  door::Display held_;
  double exposure_;
};

class Render {
 public:
  Render(std::shared_ptr<Engine> engine, FrameOptions options);
  ~Render();
  void update(const py::kwargs& changes = {});
  bool wait(const std::optional<double>& seconds, const py::object& progress);
  std::string state() const;
  void cancel();
  std::unique_ptr<Pixels> pixels(const std::string& aov) const;
  void read(const std::string& aov, const py::buffer& into, bool top_down) const;
  /// False: the AOV's pixels have another size, or none are there yet.
  bool show(const std::string& aov, const py::buffer& into, const py::object& display, bool top_down);

 private:
  /// Memory of Python's, and what of the pixels it has.
  struct Shown {
    py::object into, display;  // held, so that no other object has their addresses
    double exposure = 0;
    AlabasterMemory memory{};
  };
  const door::Buffer& buffer(const std::string& aov) const;
  std::shared_ptr<Engine> engine_;
  FrameOptions options_;
  std::vector<door::Buffer> buffers_;
  std::map<std::string, Shown> shown_;
  door::Pass pass_;
};

py::dict progress_of(const AlabasterProgress& progress);

void add_exceptions(py::module_& module);
void add_scene(py::module_& module);
void add_renderer(py::module_& module);

}  // namespace alabaster::python
