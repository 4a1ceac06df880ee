#include "delegate/python/objects.h"

namespace alabaster::python {
namespace {

/// Exceptions by status; all derive from hdalabaster.Error.
struct Exceptions {
  py::object error, argument, missing, scene, render, output, cancelled;
};
Exceptions& exceptions() {
  static auto* held = new Exceptions;
  return *held;
}

py::object make_exception(py::module_& module, const char* name, const char* documentation, const py::tuple& bases) {
  const std::string full = std::string("hdalabaster.") + name;
  auto made =
      py::reinterpret_steal<py::object>(PyErr_NewExceptionWithDoc(full.c_str(), documentation, bases.ptr(), nullptr));
  module.attr(name) = made;
  return made;
}

py::object exception_of(AlabasterStatus status) {
  switch (status) {
    case ALABASTER_INVALID_ARGUMENT:
      return exceptions().argument;
    case ALABASTER_NOT_FOUND:
      return exceptions().missing;
    case ALABASTER_INPUT_FAILED:
    case ALABASTER_DEGRADED:
      return exceptions().scene;
    case ALABASTER_RENDER_FAILED:
    case ALABASTER_OUT_OF_MEMORY:
      return exceptions().render;
    case ALABASTER_OUTPUT_FAILED:
      return exceptions().output;
    case ALABASTER_INTERRUPTED:
      return exceptions().cancelled;
    default:
      return exceptions().error;
  }
}

}  // namespace

void add_exceptions(py::module_& module) {
  Exceptions& e = exceptions();
  const auto builtin = [](PyObject* type) { return py::reinterpret_borrow<py::object>(type); };
  e.error = make_exception(module, "Error", "Something failed; the text says what, and the remedy.",
                           py::make_tuple(builtin(PyExc_RuntimeError)));
  const auto derive = [&](const char* name, const char* documentation, PyObject* also = nullptr) {
    const auto bases = also ? py::tuple(py::make_tuple(e.error, builtin(also))) : py::tuple(py::make_tuple(e.error));
    return make_exception(module, name, documentation, bases);
  };
  e.argument = derive("ArgumentError", "A call has a wrong argument.", PyExc_ValueError);
  e.missing = derive("NotFoundError", "There is no prim, AOV or node of that name.", PyExc_LookupError);
  e.scene = derive("SceneError", "A scene, or a file that it names, cannot be read or drawn as asked.");
  e.render = derive("RenderError", "A render failed, or memory ran out.");
  e.output = derive("OutputError", "A file could not be written.", PyExc_OSError);
  e.cancelled = derive("Cancelled", "A render was cancelled; its picture so far is there.");
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(std::move(thrown));
    } catch (const c_api::Error& error) {
      PyErr_SetObject(exception_of(error.status).ptr(), message_to_python(error.what()).ptr());
    }
  });
}

}  // namespace alabaster::python
