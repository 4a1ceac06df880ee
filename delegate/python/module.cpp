// The module's names as Python sees them. delegate/python/hdalabaster/__init__.pyi has their types.
#include "delegate/python/objects.h"

namespace alabaster::python {

namespace {

void add_primvar(py::module_& module) {
  py::class_<Primvar>(module, "Primvar", "Values of a mesh with how they are spread over it.")
      .def(py::init([](const py::object& values, const Text& interpolation, const py::object& indices, const Text& role,
                       const py::object& motion) {
             auto made = make_object<Primvar>(values, interpolation);
             made->indices = indices, made->role = role, made->motion = motion;
             return made;
           }),
           py::arg("values"), py::arg("interpolation") = "vertex", py::arg("indices") = py::none(),
           py::arg("role") = "", py::arg("motion") = py::none(),
           "interpolation: constant, uniform, varying, vertex, faceVarying or instance. role of texture coordinates: "
           "textureCoordinate. motion=[(time, values), ...] of points, normals and instances, with times in frames.");
}

py::class_<Scene> add_files(py::module_& module) {
  py::class_<Scene> scene(module, "Scene", py::custom_type_setup(&show_report_to_collector<Scene>),
                          "Meshes, materials, lights, cameras and render settings by path. A set_ call replaces the "
                          "prim of that path and finds out what differs; it may come before or while a renderer draws "
                          "the scene. Arrays of float32 and int32 (float64 for matrices) that are contiguous are not "
                          "copied: leave them unchanged. Matrices have the translation in their last row.");
  scene
      .def(py::init([](const py::object& report) { return make_object<Scene>(report); }), py::kw_only(),
           py::arg("report") = py::none(),
           "report(severity, code, where, text) hears of faults in files; by default they are logged under "
           "'hdalabaster'.")
      .def(
          "load", [](Scene& s, const py::object& file, const py::kwargs& options) { return s.load(file, options); },
          py::arg("file"),
          "Adds a scene file (.gltf, .glb, .usd, .usda, .usdc, .usdz, .json, .alab) and completes it with a camera and "
          "lights where it has none. "
          "Options are the program's: overrides=['materials/skin.roughness=0.3'], camera, dome, scene, animation, "
          "variant, time (seconds), shutter (open and close, in frames), frames_per_second, next_frame "
          "(AOV motion is to show the models' animations), keep_going, allow_outside. "
          "Returns settings (the path of the render settings), color_config and notes.")
      .def(
          "write",
          [](Scene& s, const py::object& file, const py::object& overrides, const py::kwargs& frame) {
            s.write(file, overrides, frame);
          },
          py::arg("file"), py::kw_only(), py::arg("overrides") = py::none(),
          "Writes the scene to an archive (NAME.alab), which load and the program read: every prim, with render "
          "settings "
          "that draw what Renderer.render draws with the same options: width, height, camera, settings, window, "
          "pixel_aspect, render_tags, roots, excluded. overrides={'samples': 16} come over the render settings. Images "
          "of files are named by path and digest. OutputError says why it is not written.")
      .def(
          "clear",
          [](Scene& s) { s.run([](const AlabasterApi& api, AlabasterScene* h) { return api.scene_clear(h); }); },
          "Removes every prim.")
      .def(
          "remove",
          [](Scene& s, const PrimPath& path) {
            s.run([&](const AlabasterApi& api, AlabasterScene* h) { return api.remove(h, path.c_str()); });
          },
          py::arg("path"), "Removes a prim.")
      .def_property_readonly("prims", &Scene::prims, "The type of every prim, by its path.");
  return scene;
}

void add_fields_of_prims(py::class_<Scene>& scene) {
  scene
      .def(
          "set",
          [](Scene& s, const PrimPath& path, const Text& kind, const py::object& fields, const py::kwargs& options) {
            s.set(path, kind, fields, options);
          },
          py::call_guard<FreeReturned>(), py::arg("path"), py::arg("kind"), py::arg("fields") = py::none(),
          "Makes a prim of any kind, or replaces the one of that path: set('/m', 'mesh', {'primvars:points': points, "
          "'primvars:st:interpolation': 'faceVarying'}, face_vertex_counts=counts, double_sided=False). Fields that "
          "are not given have their defaults. alabaster_types.h lists the kinds, delegate/manual/parameters has a page "
          "of fields for each. As an argument, doubleSided is double_sided. A pair of texts is a connection of a "
          "material's input. An unknown name is an error that names the nearest.")
      .def(
          "edit",
          [](Scene& s, const PrimPath& path, const py::object& fields, const py::kwargs& options) {
            s.edit(path, fields, options);
          },
          py::call_guard<FreeReturned>(), py::arg("path"), py::arg("fields") = py::none(),
          "Changes the given fields of a prim: edit('/key', intensity=3). None sets a field's default.")
      .def(
          "set_instance_values",
          [](Scene& s, const PrimPath& path, size_t first, const py::kwargs& options) {
            s.set_instance_values(path, first, options);
          },
          py::call_guard<FreeReturned>(), py::arg("path"), py::arg("first"),
          "Replaces instances from number first on, in arrays that set_instancer was given: transforms, translations, "
          "rotations, scales, and values by instance by their names (tint=colors of 'primvars:tint'). Costs what it "
          "changes.");
}

}  // namespace

void add_scene(py::module_& module) {
  add_primvar(module);
  py::class_<Scene> scene = add_files(module);
  add_fields_of_prims(scene);
  module.def("_shape_of", [](const py::object& values, const Text& name) {
    py::list shape;
    for (const size_t length : shape_of(values, name)) shape.append(length);
    return shape;
  });
  module.def("_absorbed_share", [](double color, double anisotropy) {
    double share = 0;
    c_api::check(c_api::api().absorbed_share(color, anisotropy, &share));
    return share;
  });
}

}  // namespace alabaster::python

namespace {
// The base of all classes that pybind11 makes, also those of other modules.
newfunc make_pybind11_object = nullptr;

// pybind11 2.10 throws through CPython where the base itself is called, as pickle does (copyreg._reduce_ex).
PyObject* refuse_the_base(PyTypeObject* type, PyObject* arguments, PyObject* keywords) {
  if (type != reinterpret_cast<PyTypeObject*>(pybind11::detail::get_internals().instance_base))
    return make_pybind11_object(type, arguments, keywords);
  PyErr_SetString(PyExc_TypeError, "objects of hdalabaster cannot be pickled, copied or made from their base class");
  return nullptr;
}

void guard_the_base() {
  auto* base = reinterpret_cast<PyTypeObject*>(pybind11::detail::get_internals().instance_base);
  if (base->tp_new == &refuse_the_base) return;
  make_pybind11_object = base->tp_new;
  base->tp_new = &refuse_the_base;
}

constexpr const char* kNotMain = "hdalabaster runs in Python's main interpreter alone, and this is a sub-interpreter";

bool is_main_interpreter() {
  return PyInterpreterState_Get() == PyInterpreterState_Main();
}
}  // namespace

#define PyInit__hdalabaster init_by_pybind11  // the function that PYBIND11_MODULE defines, and that Python looks for
PYBIND11_MODULE(_hdalabaster, module) {
  using namespace alabaster::python;
  // CPython copies a module of the main interpreter into others without a call of this: __init__.py checks.
  module.def("_check_interpreter", [] {
    if (!is_main_interpreter()) throw py::import_error(kNotMain);
  });
  guard_the_base();
  module.doc() = "Path-traced subsurface scattering: scenes, renders, pixels.";
  add_exceptions(module);
  add_scene(module);
  add_renderer(module);
  const std::string versions = alabaster::c_api::api().versions;
  module.attr("__version__") = versions.substr(0, versions.find('\n'));
  module.attr("versions") = versions;
}
#undef PyInit__hdalabaster

// pybind11 waits without end in an interpreter that is not the main one.
extern "C" PYBIND11_EXPORT PyObject* PyInit__hdalabaster() {  // NOLINT(bugprone-reserved-identifier): Python's name
  if (is_main_interpreter()) return init_by_pybind11();
  PyErr_SetString(PyExc_ImportError, kNotMain);
  return nullptr;
}
