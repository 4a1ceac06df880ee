#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>

#include "delegate/python/objects.h"

namespace alabaster::python {
namespace {

/// Engines that were made, to be stopped when the interpreter ends: their threads must not outlast the library's
/// memory.
std::vector<std::weak_ptr<Engine>>& engines() {
  static auto* made = new std::vector<std::weak_ptr<Engine>>;
  return *made;
}

void keep(const std::shared_ptr<Engine>& engine) {
  auto& made = engines();
  made.erase(std::remove_if(made.begin(), made.end(), [](const auto& one) { return one.expired(); }), made.end());
  made.push_back(engine);
}

void end() {
  std::vector<std::shared_ptr<Engine>> living;
  for (const auto& one : engines())
    if (const auto engine = one.lock()) living.push_back(engine);
  leave_library([&] {
    for (const auto& engine : living) c_api::api().stop(engine->delegate.get());
  });
}

struct SettingAnswer {
  std::string key, documentation;
  Answer otherwise, minimum, maximum;
  std::vector<std::string> choices;
};

class Renderer : public NeverImplicit {
 public:
  Renderer(const py::object& scene, py::object report, const py::dict& settings) : report_(std::move(report)) {
    const c_api::Parameters held = parameters(settings, "settings");
    const c_api::Scene none;
    const c_api::Scene& shown = scene.is_none() ? none : scene_of(scene).handle();
    const auto engine = std::make_shared<Engine>(report_);
    engine->run([&](const AlabasterApi&, AlabasterDelegate*, Unlocked&) {
      engine->delegate = c_api::make_delegate(shown, held, &Messages::hear, &engine->messages);
      return int32_t(ALABASTER_OK);
    });
    keep(engine);
    engine_ = engine;
  }
  const py::object& report() const { return report_; }
  /// `call(api, delegate)`
  template <class Call>
  void run(const Call& call) {
    engine_->run([&](const AlabasterApi& api, AlabasterDelegate* held, Unlocked&) { return call(api, held); });
  }

  void show(const py::object& scene) {
    AlabasterScene* shown = scene.is_none() ? nullptr : scene_of(scene).handle().get();
    run([&](const AlabasterApi& api, AlabasterDelegate* delegate) { return api.show(delegate, shown); });
  }
  void set(const py::dict& settings) {
    const c_api::Parameters held = parameters(settings, "settings");
    const std::vector<AlabasterParameter> raw = c_api::pass(held);
    run([&](const AlabasterApi& api, AlabasterDelegate* delegate) {
      return api.set_settings(delegate, raw.data(), raw.size());
    });
  }
  py::object get(const Text& name) {
    return last_of(engine_->ask([&](const AlabasterApi& api, AlabasterDelegate* delegate, AlabasterVisit visit,
                                    void* user) { return api.get_setting(delegate, name.c_str(), visit, user); }));
  }
  py::dict describe();
  py::dict stats() {
    const Answers told = engine_->ask([](const AlabasterApi& api, AlabasterDelegate* delegate, AlabasterVisit visit,
                                         void* user) { return api.stats(delegate, visit, user); });
    py::dict all;
    for (const auto& [name, value] : told) all[name_to_python(name)] = value.to_python();
    return all;
  }
  py::dict progress() {
    auto now = c_api::sized<AlabasterProgress>();
    run([&](const AlabasterApi& api, AlabasterDelegate* delegate) { return api.progress(delegate, &now); });
    return progress_of(now);
  }
  py::object command(const Text& name, const py::dict& arguments) {
    const c_api::Parameters held = parameters(arguments, "arguments");
    const std::vector<AlabasterParameter> raw = c_api::pass(held);
    return last_of(
        engine_->ask([&](const AlabasterApi& api, AlabasterDelegate* delegate, AlabasterVisit visit, void* user) {
          return api.command(delegate, name.c_str(), raw.data(), raw.size(), visit, user);
        }));
  }
  std::unique_ptr<Render> start(const FrameChanges& frame) {
    auto render = make_object<Render>(engine_);
    render->update(frame);
    return render;
  }
  std::unique_ptr<Render> render(const FrameChanges& frame, const py::object& progress) {
    run([](const AlabasterApi& api, AlabasterDelegate* delegate) { return api.resume(delegate); });
    auto render = start(frame);
    render->wait(py::none(), progress);
    return render;
  }
  py::list record(const py::args& files, const Text& settings, const py::object& aovs, bool keep_going,
                  const py::object& progress);

 private:
  static Scene& scene_of(const py::object& scene) {
    return object_of<Scene>(scene, "scene", "an hdalabaster.Scene or None");
  }
  static py::object last_of(const Answers& told) { return told.empty() ? py::none() : told.back().second.to_python(); }
  py::object report_;
  std::shared_ptr<Engine> engine_;
};

py::dict Renderer::describe() {
  std::vector<SettingAnswer> told;
  const auto visit = [](void* user, const AlabasterSetting* s) {
    static_cast<std::vector<SettingAnswer>*>(user)->push_back({s->key,
                                                               s->documentation,
                                                               Answer(s->default_value),
                                                               Answer(s->minimum),
                                                               Answer(s->maximum),
                                                               {s->choices, s->choices + s->choice_count}});
  };
  run([&](const AlabasterApi& api, AlabasterDelegate* delegate) { return api.get_settings(delegate, visit, &told); });
  py::dict all;
  for (const SettingAnswer& setting : told) {
    py::dict entry;
    entry["documentation"] = message_to_python(setting.documentation);
    entry["default"] = setting.otherwise.to_python();
    entry["minimum"] = setting.minimum.to_python();
    entry["maximum"] = setting.maximum.to_python();
    py::list choices;
    for (const std::string& choice : setting.choices) choices.append(name_to_python(choice));
    entry["choices"] = choices;
    all[name_to_python(setting.key)] = entry;
  }
  return all;
}

std::vector<const char*> pointers(const std::vector<std::string>& texts) {
  std::vector<const char*> raw;
  for (const std::string& text : texts) raw.push_back(text.c_str());
  return raw;
}

/// The state of a recording that calls back.
struct Recording {
  py::object progress;
  std::exception_ptr error = nullptr;  // of the callback
  Unlocked* unlocked = nullptr;
  const pid_t process = getpid();

  static int32_t tell(void* user, const AlabasterProgress* now) {
    auto& recording = *static_cast<Recording*>(user);
    if (interpreter_ends()) return 0;
    const Unlocked::Locked locked(*recording.unlocked);
    int32_t continues = 0;
    try {
      continues = with_host_code([&] { return recording.continues(*now); });
    } catch (...) {
      recording.error = std::current_exception();
    }
    if (getpid() != recording.process) recording.end_child();
    return continues;
  }

 private:
  int32_t continues(const AlabasterProgress& now) const {
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (progress.is_none()) return 1;
    const py::object answer = progress(progress_of(now));
    return answer.is_none() || flag(answer, "what progress returns") ? 1 : 0;
  }
  /// The callback forked: the recording cannot continue without the threads of the parent.
  [[noreturn]] void end_child() const {
    try {
      if (error) std::rethrow_exception(error);
      PyErr_SetString(PyExc_ValueError, "a process that a progress callback forks must end within the callback");
    } catch (py::error_already_set& thrown) {
      thrown.restore();
    } catch (const std::exception& thrown) {
      PyErr_SetString(PyExc_RuntimeError, thrown.what());
    }
    PyErr_PrintEx(0);  // ends the process where the error is SystemExit
    Py_Exit(1);
  }
};

py::list Renderer::record(const py::args& files, const Text& settings, const py::object& aovs, bool keep_going,
                          const py::object& progress) {
  if (!progress.is_none() && PyCallable_Check(progress.ptr()) == 0)
    throw wrong_type("progress", "a function", progress);
  Recording recording{progress};
  std::vector<std::string> names;
  for (const py::handle file : files) names.push_back(file_name(file, "a file"));
  const std::vector<std::string> layers = texts(aovs, "aovs");
  const auto raw_names = pointers(names), raw_aovs = pointers(layers);
  auto options = c_api::sized<AlabasterRecordOptions>();
  options.settings = c_api::or_null(settings);
  options.files = raw_names.data(), options.file_count = raw_names.size();
  options.aovs = raw_aovs.data(), options.aov_count = raw_aovs.size();
  options.keep_going = keep_going;
  options.progress = &Recording::tell;
  options.user = &recording;
  Answers written;
  try {
    engine_->run([&](const AlabasterApi& api, AlabasterDelegate* delegate, Unlocked& unlocked) {
      recording.unlocked = &unlocked;
      const std::lock_guard turn(engine_->turn);
      engine_->refuse_while_recording();
      if (const AlabasterStatus status = api.restart(delegate)) return status;  // from a stop or a cancel
      engine_->records = true;
      const AlabasterStatus status = api.record(delegate, &options, &keep_answer, &written);
      engine_->records = false;
      return status == ALABASTER_DEGRADED && keep_going ? int32_t(ALABASTER_OK) : status;
    });
  } catch (const c_api::Error&) {
    if (recording.error) std::rethrow_exception(recording.error);
    throw;
  }
  if (recording.error) std::rethrow_exception(recording.error);
  py::list told;
  for (const auto& entry : written) told.append(entry.second.to_python());
  return told;
}

/// Pixels, 0 or more.
int32_t length_of(py::handle value, const std::string& name) {
  const int32_t length = whole(value, name);
  if (length < 0)
    throw py::value_error(name + " is " + std::to_string(length) +
                          "; it must be at least 1, or 0 for that of the render settings");
  return length;
}

void set_camera(FrameChanges& changes, py::handle value) {
  if (PyDict_Check(value.ptr())) {
    c_api::Parameters fields;
    add_fields("camera", value, "camera", &fields);
    if (fields.empty()) fields.emplace_back("transform", Value());  // a camera of defaults
    changes.push_back([fields](FrameOptions& o) { o.camera.clear(), o.free_camera = fields; });
    return;
  }
  if (!value.is_none() && !PyUnicode_Check(value.ptr())) throw wrong_type("camera", "a path or a dict", value);
  changes.push_back(
      [path = text_or_none(value, "camera")](FrameOptions& o) { o.camera = path, o.free_camera.clear(); });
}

/// False: there is no such option of texts.
bool change_selection(FrameChanges& changes, const std::string& name, py::handle value) {
  for (const auto& [known, member] :
       {std::pair("render_tags", &FrameOptions::render_tags), std::pair("roots", &FrameOptions::roots),
        std::pair("excluded", &FrameOptions::excluded)})
    if (name == known) {
      const Value selected = value.is_none() ? Value() : Value::tokens(texts(value, name));
      changes.push_back([selected, held = member](FrameOptions& o) { o.*held = selected; });
      return true;
    }
  return false;
}

}  // namespace

AlabasterRect rect_of(py::handle value, const std::string& name) {
  if (value.is_none()) return {};
  const std::vector<py::object> sides = items(value, name);
  if (sides.size() != 4) throw py::value_error(name + " must be (min_x, min_y, max_x, max_y)");
  std::array<int32_t, 4> read{};
  std::transform(sides.begin(), sides.end(), read.begin(),
                 [&](const py::object& side) { return whole(side, "each of " + name); });
  return {read[0], read[1], read[2], read[3]};
}

FrameChanges frame_changes(const py::kwargs& given) {
  FrameChanges changes;
  for (const auto& [name, value] : entries(given, "keyword arguments")) {
    if (name == "width")
      changes.push_back([width = length_of(value, name)](FrameOptions& o) { o.width = width; });
    else if (name == "height")
      changes.push_back([height = length_of(value, name)](FrameOptions& o) { o.height = height; });
    else if (name == "aovs")
      changes.push_back([aovs = texts(value, name)](FrameOptions& o) { o.aovs = aovs; });
    else if (name == "camera")
      set_camera(changes, value);
    else if (name == "settings")
      changes.push_back([path = text_or_none(value, name)](FrameOptions& o) { o.settings = path; });
    else if (name == "pixel_aspect")
      changes.push_back([aspect = number(value, name)](FrameOptions& o) { o.pixel_aspect = aspect; });
    else if (name == "window")
      changes.push_back([window = rect_of(value, name)](FrameOptions& o) { o.window = window; });
    else if (!change_selection(changes, name, value))
      throw py::type_error("unexpected keyword argument '" + name + "'");
  }
  return changes;
}

namespace {

py::object take_progress(py::kwargs& given) {
  return given.contains("progress") ? py::object(given.attr("pop")("progress")) : py::object(py::none());
}

getbufferproc g_get_buffer = nullptr;  // pybind11's, which lets exceptions pass into Python

int get_buffer(PyObject* pixels, Py_buffer* view, int flags) {
  try {
    return g_get_buffer(pixels, view, flags);
  } catch (const std::exception& error) {
    PyErr_SetString(PyExc_TypeError, error.what());
  }
  if (view) view->obj = nullptr;
  return -1;
}

void add_renders(py::module_& module) {
  py::class_<Pixels>(
      module, "Pixels", py::buffer_protocol(), py::custom_type_setup([](PyHeapTypeObject* type) {
        g_get_buffer = std::exchange(type->as_buffer.bf_getbuffer, &get_buffer);
        show_report_to_collector<Pixels>(type);
      }),
      "Pixels of one AOV as they were when they were taken. They lie where the renderer wrote them, with the uppermost "
      "row first: numpy.asarray(pixels) copies nothing, and the array may outlive everything.")
      .def_buffer(&Pixels::info)
      .def_property_readonly(
          "width", [](const Pixels& p) { return p.get().width; }, "In pixels.")
      .def_property_readonly(
          "height", [](const Pixels& p) { return p.get().height; }, "In pixels.")
      .def_property_readonly(
          "generation", [](const Pixels& p) { return p.get().generation; }, "Rises when pixels change.")
      .def(
          "numpy", [](const py::object& self) { return py::module_::import("numpy").attr("asarray")(self); },
          "The pixels as an array of (height, width) or (height, width, components), without a copy.");

  py::class_<Render>(module, "Render", py::custom_type_setup(&show_report_to_collector<Render>),
                     "A render that runs in the background. Renderer.start makes it.")
      .def(
          "update", [](Render& r, const py::kwargs& changes) { r.update(frame_changes(changes)); },
          py::call_guard<FreeReturned>(),
          "Renders again what has changed in the scene, the settings or the camera. Arguments are those of "
          "Renderer.start, and change what they name. Until the new picture covers the frame, the old one stays.")
      .def("wait", &Render::wait, py::arg("seconds") = py::none(), py::arg("progress") = py::none(),
           "Waits until the render is over (True) or `seconds` have passed (False). progress(dict) is called about ten "
           "times a second; where it returns False the render is cancelled. Ctrl-C cancels, too.")
      .def("cancel", &Render::cancel, "Stops the renderer; the picture so far can be read.")
      .def_property_readonly("state", &Render::state,
                             "idle, preparing, rendering, paused, stopped, converged or failed.")
      .def("pixels", &Render::pixels, py::arg("aov") = "color", "The pixels of an AOV as they are now.")
      .def("__getitem__", &Render::pixels, "The same as pixels(aov).")
      .def("read", &Render::read, py::arg("aov"), py::arg("into"), py::arg("top_down") = true,
           "Copies the pixels of an AOV into a contiguous array of their type and shape, or of one axis. Another array "
           "is "
           "an ArgumentError that names both.")
      .def("show", &Render::show, py::arg("aov"), py::arg("into"), py::arg("display") = py::none(),
           py::arg("top_down") = true,
           "Brings a contiguous array (height, width, components) of float32, float16 or uint8, or int32 for ids, up "
           "to date: converts "
           "what the array does not show yet, if it is the array of the last call. With a Display, for that display. "
           "False: the pixels have another size, and nothing was written.")
      .def(
          "pick", &Render::pick, py::arg("window"),
          "Returns the faces that window=(min_x, min_y, max_x, max_y) shows, in pixels with y down, max excluded. Each "
          "is listed once, the nearest to its middle first. A hit is a dict of path (of the mesh), face (-1 without "
          "AOV "
          "elementId), instance_id (as AOV instanceId counts; 0 without it), instances (pairs of an instancer's path "
          "and the index in it, from the innermost outwards), x and y (a pixel that shows it). aovs must have named "
          "'primId'. The scene must be as it was at the last start or update.");

  py::class_<Display>(
      module, "Display",
      "Converts pixels for a screen, by OpenColorIO. Texts that are missing are those of the configuration.")
      .def(py::init([](const py::object& color_config, const Text& display, const Text& view, const Text& look,
                       double exposure) { return make_object<Display>(color_config, display, view, look, exposure); }),
           py::arg("color_config") = py::none(), py::kw_only(), py::arg("display") = "", py::arg("view") = "",
           py::arg("look") = "", py::arg("exposure") = 0.0)
      .def_property("exposure", &Display::exposure, &Display::set_exposure, "In stops. A new one renders nothing.");
}

py::class_<Renderer> renderer_class(py::module_& module) {
  py::class_<Renderer> renderer(module, "Renderer", py::custom_type_setup(&show_report_to_collector<Renderer>),
                                "Draws a scene. Settings are those of schemas/render_settings.json.");
  renderer
      .def(py::init([](const py::object& scene, const py::object& report, const py::kwargs& settings) {
             return make_object<Renderer>(scene, report, settings);
           }),
           py::arg("scene") = py::none(), py::kw_only(), py::arg("report") = py::none(), py::call_guard<FreeReturned>(),
           "report(severity, code, where, text) hears of faults; by default they are logged under 'hdalabaster'.")
      .def("show", &Renderer::show, py::arg("scene"), "Draws another scene; None: none.")
      .def(
          "set", [](Renderer& r, const py::kwargs& settings) { r.set(settings); }, py::call_guard<FreeReturned>(),
          "Changes settings, all or none: set(samples=64). None takes a setting back.")
      .def("get", &Renderer::get, py::arg("name"),
           "The value of a setting. An unknown name is an error that names the nearest.")
      .def("describe_settings", &Renderer::describe,
           "Every setting: documentation, default, minimum, maximum, choices.")
      .def("stats", &Renderer::stats, "What the renderer has counted and measured, by name.")
      .def("progress", &Renderer::progress, "fraction, seconds, samples_done and samples_total of the running render.")
      .def(
          "command",
          [](Renderer& r, const Text& name, const py::kwargs& arguments) { return r.command(name, arguments); },
          py::arg("name"), py::call_guard<FreeReturned>(),
          "dumpScene, requirements, names, tracePixel (x=, y=, sample=).");
  return renderer;
}

auto control(AlabasterStatus (*AlabasterApi::*call)(AlabasterDelegate*)) {
  return
      [call](Renderer& r) { r.run([call](const AlabasterApi& api, AlabasterDelegate* d) { return (api.*call)(d); }); };
}

void add_control(py::class_<Renderer>& renderer) {
  renderer
      .def(
          "start", [](Renderer& r, const py::kwargs& frame) { return r.start(frame_changes(frame)); },
          py::call_guard<FreeReturned>(),
          "Begins to render: width, height, aovs=['color'], camera, settings, window=(min_x, min_y, max_x, max_y), "
          "pixel_aspect. Those that are missing are those of the scene's render settings. camera is a path, or a dict "
          "of transform, motion and parameters: a camera that no prim of the scene is. render_tags, roots and excluded "
          "select meshes: by tag, and by paths that hold them.")
      .def(
          "render",
          [](Renderer& r, py::kwargs frame) {
            const py::object progress = take_progress(frame);
            return r.render(frame_changes(frame), progress);
          },
          py::call_guard<FreeReturned>(),
          "Like start, and waits: progress as for Render.wait. A pause from before ends.")
      .def("record", &Renderer::record, py::kw_only(), py::arg("settings") = "", py::arg("aovs") = py::tuple(),
           py::arg("keep_going") = false, py::arg("progress") = py::none(),
           "Renders to files (.exr, .png, .tif, .jpg; without names, to those of the render settings), waits, and "
           "returns those that were written. aovs are further layers of the .exr files.")
      .def("stop", control(&AlabasterApi::stop),
           "Stops what runs, until the next start, update or record. Renders that ran stay stopped until their update.")
      .def("restart", control(&AlabasterApi::restart),
           "Ends a stop. Nothing renders until the next start, update or record, which end a stop themselves.")
      .def("pause", control(&AlabasterApi::pause),
           "Holds what renders, with its samples, until resume. A start or update that begins another render, render "
           "and record end the pause. One from before the first start holds that render.")
      .def("resume", control(&AlabasterApi::resume), "Ends a pause: renders continue with the samples that they have.");
}

}  // namespace

void add_renderer(py::module_& module) {
  add_renders(module);
  py::class_<Renderer> renderer = renderer_class(module);
  add_control(renderer);
  module.def("_end", &end);
  py::module_::import("atexit").attr("register")(module.attr("_end"));
  module.def("_forget_threads", [] {
    forget_threads();
    forget_returning_threads();
    // Exit handlers of libraries wait for threads that a forked child lacks, as those of log4cplus do, which comes with
    // OpenImageIO. Python has ended when they run.
    on_exit(
        [](int status, void*) {
          std::fflush(nullptr);
          _exit(status);
        },
        nullptr);
  });
  py::module_::import("os").attr("register_at_fork")(py::arg("after_in_child") = module.attr("_forget_threads"));
}

}  // namespace alabaster::python
