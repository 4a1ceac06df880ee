#include <pybind11/stl.h>

#include <set>

#include "delegate/python/objects.h"

namespace alabaster::python {
namespace {

/// Engines that live, to be stopped when the interpreter ends: their threads must not outlast the library's memory.
std::set<Engine*>& engines() {
  static auto* living = new std::set<Engine*>;
  return *living;
}

class Renderer {
 public:
  Renderer(const py::object& scene, py::object report, const py::dict& settings) {
    const door::Parameters held = parameters(settings);
    auto engine = std::make_unique<Engine>(std::move(report));
    const door::Scene none;
    const door::Scene& shown = scene.is_none() ? none : scene.cast<Scene&>().handle();
    std::optional<door::Error> error;
    {
      const py::gil_scoped_release unlocked;
      try {
        engine->delegate = door::make_delegate(shown, held, &Messages::hear, &engine->messages);
      } catch (const door::Error& e) {
        error.emplace(e);
      }
    }
    engine->messages.deliver();
    if (error) throw *error;
    engines().insert(engine.get());
    engine_ = std::shared_ptr<Engine>(engine.release(), [](Engine* e) {
      engines().erase(e);
      delete e;
    });
  }
  /// `call(api, delegate)`
  template <class Call>
  void run(const Call& call) {
    python::run(engine_->messages, [&](const AlabasterApi& api) { return call(api, engine_->delegate.get()); });
  }
  const std::shared_ptr<Engine>& engine() const { return engine_; }

  void show(const py::object& scene) {
    AlabasterScene* shown = scene.is_none() ? nullptr : scene.cast<Scene&>().handle().get();
    run([&](const AlabasterApi& api, AlabasterDelegate* delegate) { return api.show(delegate, shown); });
  }
  void set(const py::dict& settings) {
    for (const auto& [name, value] : parameters(settings)) {
      const AlabasterValue raw = value.pass();
      run([&, &key = name](const AlabasterApi& api, AlabasterDelegate* delegate) {
        return api.set_setting(delegate, key.c_str(), &raw);
      });
    }
  }
  py::object get(const std::string& name) {
    py::object told = py::none();
    ask(
        engine_->messages,
        [&](const AlabasterApi& api, AlabasterVisit visit, void* user) {
          return api.get_setting(engine_->delegate.get(), name.c_str(), visit, user);
        },
        [&](const char*, const AlabasterValue& value) { told = to_python(value); });
    return told;
  }
  py::dict describe() {
    py::dict all;
    const auto visit = [](void* user, const AlabasterSetting* setting) {
      const py::gil_scoped_acquire locked;
      py::dict entry;
      entry["documentation"] = setting->documentation;
      entry["default"] = to_python(setting->default_value);
      entry["minimum"] = to_python(setting->minimum);
      entry["maximum"] = to_python(setting->maximum);
      py::list choices;
      for (size_t i = 0; i < setting->choice_count; ++i) choices.append(setting->choices[i]);
      entry["choices"] = choices;
      (*static_cast<py::dict*>(user))[setting->key] = entry;
    };
    run([&](const AlabasterApi& api, AlabasterDelegate* delegate) { return api.get_settings(delegate, visit, &all); });
    return all;
  }
  py::dict stats() {
    py::dict all;
    ask(
        engine_->messages,
        [&](const AlabasterApi& api, AlabasterVisit visit, void* user) {
          return api.stats(engine_->delegate.get(), visit, user);
        },
        [&](const char* name, const AlabasterValue& value) { all[name] = to_python(value); });
    return all;
  }
  py::dict progress() {
    auto now = door::sized<AlabasterProgress>();
    door::check(door::api().progress(engine_->delegate.get(), &now));
    return progress_of(now);
  }
  py::object command(const std::string& name, const py::dict& arguments) {
    py::object told = py::none();
    const door::Parameters held = parameters(arguments);
    const std::vector<AlabasterParameter> raw = door::pass(held);
    ask(
        engine_->messages,
        [&](const AlabasterApi& api, AlabasterVisit visit, void* user) {
          return api.command(engine_->delegate.get(), name.c_str(), raw.data(), raw.size(), visit, user);
        },
        [&](const char*, const AlabasterValue& value) { told = to_python(value); });
    return told;
  }
  std::unique_ptr<Render> start(FrameOptions options) {
    auto render = std::make_unique<Render>(engine_, std::move(options));
    render->update();
    return render;
  }
  std::unique_ptr<Render> render(FrameOptions options, const py::object& progress) {
    auto render = start(std::move(options));
    render->wait(std::nullopt, progress);
    return render;
  }
  py::list record(const py::args& files, const std::string& settings, const std::vector<std::string>& aovs,
                  bool keep_going, const py::object& progress);

 private:
  std::shared_ptr<Engine> engine_;
};

std::vector<const char*> pointers(const std::vector<std::string>& texts) {
  std::vector<const char*> raw;
  for (const std::string& text : texts) raw.push_back(text.c_str());
  return raw;
}

/// The state of a recording that calls back.
struct Recording {
  py::object progress;
  std::optional<py::error_already_set> error;  // of the callback
  std::vector<std::string> written;

  static int32_t tell(void* user, const AlabasterProgress* now) {
    auto& recording = *static_cast<Recording*>(user);
    const py::gil_scoped_acquire locked;
    try {
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      if (recording.progress.is_none()) return 1;
      const py::object answer = recording.progress(progress_of(*now));
      return answer.is_none() || answer.cast<bool>();
    } catch (py::error_already_set& error) {
      recording.error.emplace(std::move(error));
      return 0;
    }
  }
};

py::list Renderer::record(const py::args& files, const std::string& settings, const std::vector<std::string>& aovs,
                          bool keep_going, const py::object& progress) {
  Recording recording{progress, std::nullopt, {}};
  std::vector<std::string> names;
  for (const py::handle file : files) names.push_back(py::str(file).cast<std::string>());
  const auto raw_names = pointers(names), raw_aovs = pointers(aovs);
  auto options = door::sized<AlabasterRecordOptions>();
  options.settings = door::or_null(settings);
  options.files = raw_names.data(), options.file_count = raw_names.size();
  options.aovs = raw_aovs.data(), options.aov_count = raw_aovs.size();
  options.keep_going = keep_going;
  options.progress = &Recording::tell;
  options.user = &recording;
  const AlabasterVisit keep = [](void* user, const char*, const AlabasterValue* file) {
    static_cast<Recording*>(user)->written.emplace_back(static_cast<const char*>(file->data));
  };
  try {
    run([&](const AlabasterApi& api, AlabasterDelegate* delegate) {
      const AlabasterStatus status = api.record(delegate, &options, keep, &recording);
      return status == ALABASTER_DEGRADED && keep_going ? int32_t(ALABASTER_OK) : status;
    });
  } catch (const door::Error&) {
    if (recording.error) throw std::move(*recording.error);
    throw;
  }
  return py::cast(recording.written);
}

void set_camera(FrameOptions& options, py::handle value) {
  options.camera.clear();
  options.free_camera.reset();
  if (py::isinstance<py::dict>(value))
    options.free_camera.emplace(py::reinterpret_borrow<py::dict>(value));
  else if (!value.is_none())
    options.camera = value.cast<std::string>();
}

FrameOptions frame_options(const py::kwargs& given) {
  FrameOptions options;
  options.change(given);
  return options;
}

}  // namespace

void FrameOptions::change(const py::kwargs& given) {
  for (const auto& [key, value] : given) {
    const auto name = key.cast<std::string>();
    if (name == "width")
      width = value.cast<int>();
    else if (name == "height")
      height = value.cast<int>();
    else if (name == "aovs")
      aovs = value.cast<std::vector<std::string>>();
    else if (name == "camera")
      set_camera(*this, value);
    else if (name == "settings")
      settings = value.is_none() ? "" : value.cast<std::string>();
    else if (name == "pixel_aspect")
      pixel_aspect = value.cast<double>();
    else if (name == "render_tags")
      render_tags = Tokens(value);
    else if (name == "roots")
      roots = Tokens(value);
    else if (name == "excluded")
      excluded = Tokens(value);
    else if (name == "window") {
      const auto [x0, y0, x1, y1] = value.is_none() ? std::array<int32_t, 4>{} : value.cast<std::array<int32_t, 4>>();
      window = {x0, y0, x1, y1};
    } else
      throw py::type_error("unexpected keyword argument '" + name + "'");
  }
}

namespace {

py::object take_progress(py::kwargs& given) {
  return given.contains("progress") ? py::object(given.attr("pop")("progress")) : py::object(py::none());
}

void add_renders(py::module_& module) {
  py::class_<Pixels>(
      module, "Pixels", py::buffer_protocol(),
      "Pixels of one AOV as they were when they were taken. They lie where the renderer wrote them, with the uppermost "
      "row first: numpy.asarray(pixels) copies nothing, and the array may outlive everything.")
      .def_buffer(&Pixels::info)
      .def_property_readonly("width", [](const Pixels& p) { return p.get().width; })
      .def_property_readonly("height", [](const Pixels& p) { return p.get().height; })
      .def_property_readonly(
          "generation", [](const Pixels& p) { return p.get().generation; }, "Rises when pixels change.")
      .def(
          "numpy", [](const py::object& self) { return py::module_::import("numpy").attr("asarray")(self); },
          "The pixels as an array of (height, width) or (height, width, components), without a copy.");

  py::class_<Render>(module, "Render", "A render that runs in the background. Renderer.start makes it.")
      .def(
          "update", [](Render& r, const py::kwargs& changes) { r.update(changes); },
          "Renders again what has changed in the scene, the settings or the camera. Arguments are those of "
          "Renderer.start, and change what they name. Until the new picture covers the frame, the old one stays.")
      .def("wait", &Render::wait, py::arg("seconds") = py::none(), py::arg("progress") = py::none(),
           "Waits until the render is over (True) or `seconds` have passed (False). progress(dict) is called about ten "
           "times a second; where it returns False the render is cancelled. Ctrl-C cancels, too.")
      .def("cancel", &Render::cancel, "Stops the renderer; the picture so far can be read.")
      .def_property_readonly("state", &Render::state,
                             "idle, preparing, rendering, paused, stopped, converged or failed.")
      .def("pixels", &Render::pixels, py::arg("aov") = "color", "The pixels of an AOV as they are now.")
      .def("__getitem__", &Render::pixels)
      .def("read", &Render::read, py::arg("aov"), py::arg("into"), py::arg("top_down") = true,
           "Copies the pixels of an AOV into a contiguous array of their size.")
      .def("show", &Render::show, py::arg("aov"), py::arg("into"), py::arg("display") = py::none(),
           py::arg("top_down") = true,
           "Brings a contiguous array (height, width, components) of float32, float16 or uint8 up to date: converts "
           "what "
           "the array does not show yet, if it is the array of the last call. With a Display, for that display. False: "
           "the pixels have another size, and nothing was written.");

  py::class_<Display>(
      module, "Display",
      "Converts pixels for a screen, by OpenColorIO. Texts that are missing are those of the configuration.")
      .def(py::init<py::object, std::string, std::string, std::string, double>(), py::arg("color_config") = py::none(),
           py::kw_only(), py::arg("display") = "", py::arg("view") = "", py::arg("look") = "",
           py::arg("exposure") = 0.0)
      .def_property("exposure", &Display::exposure, &Display::set_exposure, "In stops. A new one renders nothing.");
}

py::class_<Renderer> renderer_class(py::module_& module) {
  py::class_<Renderer> renderer(module, "Renderer",
                                "Draws a scene. Settings are those of schemas/render_settings.json.");
  renderer
      .def(py::init([](const py::object& scene, const py::object& report, const py::kwargs& settings) {
             return std::make_unique<Renderer>(scene, report, settings);
           }),
           py::arg("scene") = py::none(), py::kw_only(), py::arg("report") = py::none(),
           "report(severity, code, where, text) hears of faults; by default they are logged under 'alabaster'.")
      .def("show", &Renderer::show, py::arg("scene"), "Draws another scene; None: none.")
      .def(
          "set", [](Renderer& r, const py::kwargs& settings) { r.set(settings); },
          "Changes settings: set(samples=64). None takes a setting back.")
      .def("get", &Renderer::get, py::arg("name"), "The value of a setting.")
      .def("describe_settings", &Renderer::describe,
           "Every setting: documentation, default, minimum, maximum, choices.")
      .def("stats", &Renderer::stats, "What the renderer has counted and measured, by name.")
      .def("progress", &Renderer::progress, "fraction, seconds, samples_done and samples_total of the running render.")
      .def(
          "command",
          [](Renderer& r, const std::string& name, const py::kwargs& arguments) { return r.command(name, arguments); },
          py::arg("name"), "dumpScene, requirements, tracePixel (x=, y=, sample=).");
  return renderer;
}

void add_control(py::class_<Renderer>& renderer) {
  renderer
      .def(
          "start", [](Renderer& r, const py::kwargs& frame) { return r.start(frame_options(frame)); },
          "Begins to render: width, height, aovs=['color'], camera, settings, window=(min_x, min_y, max_x, max_y), "
          "pixel_aspect. Those that are missing are those of the scene's render settings. camera is a path, or a dict "
          "of "
          "transform, motion and parameters: a camera that no prim of the scene is. render_tags, roots and excluded "
          "select meshes: by tag, and by paths that hold them.")
      .def(
          "render",
          [](Renderer& r, py::kwargs frame) {
            const py::object progress = take_progress(frame);
            return r.render(frame_options(frame), progress);
          },
          "Like start, and waits: progress as for Render.wait.")
      .def("record", &Renderer::record, py::kw_only(), py::arg("settings") = "", py::arg("aovs") = py::tuple(),
           py::arg("keep_going") = false, py::arg("progress") = py::none(),
           "Renders to files (.exr, .png, .tif, .jpg; without names, to those of the render settings), waits, and "
           "returns those that were written. aovs are further layers of the .exr files.")
      .def(
          "stop", [](Renderer& r) { r.run([](const AlabasterApi& api, AlabasterDelegate* d) { return api.stop(d); }); },
          "Stops what runs, until the next start, update or restart.")
      .def("restart",
           [](Renderer& r) { r.run([](const AlabasterApi& api, AlabasterDelegate* d) { return api.restart(d); }); })
      .def("pause",
           [](Renderer& r) { r.run([](const AlabasterApi& api, AlabasterDelegate* d) { return api.pause(d); }); })
      .def("resume",
           [](Renderer& r) { r.run([](const AlabasterApi& api, AlabasterDelegate* d) { return api.resume(d); }); });
}

}  // namespace

void add_renderer(py::module_& module) {
  add_renders(module);
  py::class_<Renderer> renderer = renderer_class(module);
  add_control(renderer);
  module.def("_stop_all", [] {
    for (Engine* engine : engines()) door::api().stop(engine->delegate.get());
  });
  py::module_::import("atexit").attr("register")(module.attr("_stop_all"));
}

}  // namespace alabaster::python
