// The module's classes. Internal to this room.
//
// Every call into the library releases Python's lock. The library's threads never take it: their reports, and the
// memory that they give back, wait for the next call. Arguments are read before a call, and answers are made after it:
// Python code of the host never runs within one, but for the progress callback of record.
//
// Locks are taken in this order, without Python's: Engine::turn, the library's. Render::mutex_ and Render::showing_ are
// held while no lock but a buffer's is taken. Whatever waits for one of them has released Python's lock.
#pragma once

#include <unistd.h>

#include <deque>
#include <map>
#include <mutex>
#include <optional>

#include "delegate/python/answers.h"
#include "delegate/python/lock.h"
#include "delegate/python/values.h"

namespace alabaster::python {

/// Reports of the library, until Python is told.
class Messages {
 public:
  /// `listener`: called with severity, code, where and text; None logs them under the name "hdalabaster". Borrowed:
  /// the objects of Python that deliver hold it, so that the collector can count their references.
  explicit Messages(py::handle listener) : listener_(listener) {}
  py::object listener() const { return py::reinterpret_borrow<py::object>(listener_); }
  static void hear(void* user, const AlabasterDiagnostic* diagnostic);
  void deliver();

 private:
  struct Message {
    int32_t severity;
    std::string code, where, text;
  };
  std::optional<Message> next();
  py::handle listener_;
  std::mutex mutex_;
  std::deque<Message> queue_;
};

/// Runs `call(api, unlocked)`, a function of the C interface, without the GIL. Then delivers the reports and throws if
/// the call failed.
template <class Call>
void run(Messages& messages, const Call& call) {
  std::optional<c_api::Error> error;
  {
    Unlocked unlocked;
    try {
      c_api::check(call(c_api::api(), unlocked));
    } catch (const c_api::Error& e) {
      error.emplace(e);
    }
  }
  free_returned();
  messages.deliver();
  if (error) throw *error;
}

/// pybind11 makes an object of its own accord where Python code calls T.__new__(T) without __init__. It fails here:
/// objects of the module are made by make_object.
struct NeverImplicit {
  static void* operator new(size_t) { throw py::type_error("the object has not been initialised by __init__"); }
  static void operator delete(void* held) { ::operator delete(held); }
};
template <class T, class... Arguments>
std::unique_ptr<T> make_object(Arguments&&... arguments) {
  return std::unique_ptr<T>(::new T(std::forward<Arguments>(arguments)...));
}

template <class T>
int visit_report(PyObject* object, visitproc visit, void* arg) {
  Py_VISIT(Py_TYPE(object));
  const auto* made = reinterpret_cast<py::detail::instance*>(object);
  if (made->simple_layout && made->simple_holder_constructed) {
    PyObject* const report = static_cast<const T*>(made->simple_value_holder[0])->report().ptr();
    Py_VISIT(report);
  }
  return 0;
}

/// pybind11 2.10 leaves an object that ends to the collector, while its destructor waits without Python's lock.
inline void end_untracked(PyObject* object) {
  PyObject_GC_UnTrack(object);
  py::detail::pybind11_object_dealloc(object);
}

/// For a class whose objects hold a report: Python's collector sees it. They have no tp_clear, as tuples have none: a
/// circle has an object besides that was changed after it was made, and the collector clears that one.
template <class T>
void show_report_to_collector(PyHeapTypeObject* type) {
  type->ht_type.tp_flags |= Py_TPFLAGS_HAVE_GC;
  type->ht_type.tp_traverse = &visit_report<T>;
  type->ht_type.tp_dealloc = &end_untracked;
}

class Scene : public NeverImplicit {
 public:
  explicit Scene(py::object report);
  ~Scene();
  const py::object& report() const { return report_; }
  const c_api::Scene& handle() const { return handle_; }
  Messages& messages() { return messages_; }

  py::dict load(const py::object& file, const py::dict& options);
  void write(const py::object& file, const py::object& overrides, const py::kwargs& frame);
  py::dict prims();
  void set(const std::string& path, const std::string& kind, const py::object& fields, const py::dict& options);
  void edit(const std::string& path, const py::object& fields, const py::dict& options);
  void set_instance_values(const std::string& path, size_t first, const py::dict& options);
  /// `call(api, scene)`
  template <class Call>
  void run(const Call& call) {
    python::run(messages_, [&](const AlabasterApi& api, Unlocked&) { return call(api, handle_.get()); });
  }

 private:
  py::object report_;
  Messages messages_;
  c_api::Scene handle_;
};

struct Primvar : NeverImplicit {
  Primvar(py::object held, std::string spread) : values(std::move(held)), interpolation(std::move(spread)) {}
  py::object values;
  std::string interpolation;
  py::object indices = py::none();
  std::string role;
  py::object motion = py::none();
};

/// The renderer's handles, shared by the renders that it made.
struct Engine {
  explicit Engine(py::handle report) : messages(report) {}
  ~Engine() { drop(delegate); }
  /// `call(api, delegate, unlocked)`
  template <class Call>
  void run(const Call& call) {
    python::run(messages,
                [&](const AlabasterApi& api, Unlocked& unlocked) { return call(api, delegate.get(), unlocked); });
  }
  /// Before a restart, which would disturb the recording.
  void refuse_while_recording() const {
    if (records)
      throw c_api::Error(ALABASTER_INVALID_ARGUMENT,
                         "the progress callback of record cannot start or record with the same renderer");
  }
  /// The answers of `call(api, delegate, AlabasterVisit, void*)`.
  template <class Call>
  Answers ask(const Call& call) {
    Answers told;
    run([&](const AlabasterApi& api, AlabasterDelegate* held, Unlocked&) {
      return call(api, held, &keep_answer, static_cast<void*>(&told));
    });
    return told;
  }

  Messages messages;
  c_api::Delegate delegate;
  /// Held by the one thread that starts renders or records. The callback of record may do both.
  std::recursive_mutex turn;
  bool records = false;  // the thread that holds it
};

class Pixels : public NeverImplicit {
 public:
  Pixels(std::shared_ptr<Engine> engine, std::unique_ptr<c_api::Pixels> held);
  ~Pixels();
  py::buffer_info info() const;
  const AlabasterPixels& get() const { return held_->get(); }
  const py::object& report() const { return report_; }

 private:
  std::shared_ptr<Engine> engine_;
  py::object report_;
  std::unique_ptr<c_api::Pixels> held_;
};

struct FrameOptions {
  std::vector<std::string> aovs = {"color"};
  int32_t width = 0, height = 0;
  std::string camera, settings;
  c_api::Parameters free_camera;       // fields, in the place of `camera`; empty: none
  Value render_tags, roots, excluded;  // arrays of tokens; none: those of the render settings or all
  AlabasterRect window{};
  double pixel_aspect = 0;

  /// For one call, to which it gives what is lent. The frame points at `held`.
  AlabasterFrame pass(std::vector<AlabasterParameter>* held) const;
};

/// Changes of what is given; other names are an error.
using FrameChanges = std::vector<std::function<void(FrameOptions&)>>;
FrameChanges frame_changes(const py::kwargs& given);
FrameOptions changed(FrameOptions options, const FrameChanges& changes);

/// (min_x, min_y, max_x, max_y). None: an empty one.
AlabasterRect rect_of(py::handle value, const std::string& name);

class Display : public NeverImplicit {
 public:
  Display(const py::object& color_config, const std::string& display, const std::string& view, const std::string& look,
          double exposure);
  double exposure() const { return exposure_; }
  void set_exposure(double stops);
  const c_api::Display& handle() const { return held_; }

 private:
  c_api::Display held_;
  double exposure_;
};

/// Any thread may call any function at any time.
class Render : public NeverImplicit {
 public:
  explicit Render(std::shared_ptr<Engine> engine);
  ~Render();
  const py::object& report() const { return report_; }
  void update(const FrameChanges& changes);
  bool wait(const py::object& seconds, const py::object& progress);
  std::string state();
  void cancel();
  std::unique_ptr<Pixels> pixels(const Text& aov);
  void read(const Text& aov, const py::buffer& into, bool top_down);
  /// False: the AOV's pixels have another size, or none are there yet.
  bool show(const Text& aov, const py::buffer& into, const py::object& display, bool top_down);
  py::list pick(const py::object& window);

 private:
  using SharedBuffer = std::shared_ptr<c_api::Buffer>;
  /// Memory of Python's, and what of the pixels it has.
  struct Shown {
    py::object into, display;  // held, so that no other object has their addresses
    double exposure = 0;
    AlabasterMemory memory{};

    bool is_of(const Shown& other) const;
  };
  bool wait_for(const py::object& seconds, const py::object& progress);
  /// cancel() without reports.
  void stop_quietly();
  // Without Python's lock:
  AlabasterStatus start(const AlabasterApi& api, const FrameOptions& next);
  /// Begins to render what has been built since the last call.
  void take_up(const AlabasterApi& api) const;
  /// The buffer of an AOV, as it is after take_up.
  SharedBuffer newest(const AlabasterApi& api, const std::string& aov);

  std::shared_ptr<Engine> engine_;
  py::object report_;
  c_api::Pass pass_;
  std::mutex mutex_;  // guards these two, for look-ups only
  FrameOptions options_;
  std::vector<SharedBuffer> buffers_;
  std::mutex showing_;  // guards this; one thread at a time writes to the host's memory
  std::map<std::string, Shown> shown_;
};

/// The field that an argument sets: "double_sided" is doubleSided, and arguments that are short forms have names of
/// their own ("motion"). Names with a colon or a dot stay as they are.
std::string field_name(const std::string& argument);

/// Adds a field for each entry of a dict. The type of a field decides how its value is read, and errors name the
/// argument. A Primvar adds the fields of its interpolation, indices, role and motion, too. `kind` is empty where the
/// prim is not known.
void add_fields(const std::string& kind, py::handle values, const std::string& name, c_api::Parameters* fields);

py::dict progress_of(const AlabasterProgress& progress);

void add_exceptions(py::module_& module);
void add_scene(py::module_& module);
void add_renderer(py::module_& module);

}  // namespace alabaster::python
