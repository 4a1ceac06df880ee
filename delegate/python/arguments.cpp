#include "delegate/python/arguments.h"

#include <limits>

namespace alabaster::python {
namespace {

/// Throws the error that Python has set, as one that names the argument if it is about the type or the range.
[[noreturn]] void rethrow_named(const std::string& name, const char* expected, py::handle value) {
  if (PyErr_ExceptionMatches(PyExc_TypeError) != 0) {
    PyErr_Clear();
    throw wrong_type(name, expected, value);
  }
  if (PyErr_ExceptionMatches(PyExc_OverflowError) != 0) {
    PyErr_Clear();
    throw py::value_error(name + " is too large");
  }
  throw py::error_already_set();
}

std::string bytes_of(const py::object& bytes, const std::string& name) {
  std::string held(PyBytes_AS_STRING(bytes.ptr()), size_t(PyBytes_GET_SIZE(bytes.ptr())));
  if (held.find('\0') != std::string::npos) throw py::value_error(name + " holds a zero character");
  return held;
}

}  // namespace

std::string type_name(py::handle value) {
  return Py_TYPE(value.ptr())->tp_name;
}

py::type_error wrong_type(const std::string& name, const char* expected, py::handle value) {
  return py::type_error(name + " must be " + expected + ", not " + type_name(value));
}

bool is_characters(py::handle value) {
  return PyUnicode_Check(value.ptr()) || PyBytes_Check(value.ptr()) || PyByteArray_Check(value.ptr());
}

bool is_text(py::handle value) {
  return PyUnicode_Check(value.ptr()) ||
         PyObject_HasAttrString(reinterpret_cast<PyObject*>(Py_TYPE(value.ptr())), "__fspath__") != 0;
}

double number(py::handle value, const std::string& name) {
  constexpr const char* kExpected = "a number";
  if (is_characters(value)) throw wrong_type(name, kExpected, value);
  const double read = PyFloat_AsDouble(value.ptr());
  if (read == -1 && PyErr_Occurred()) rethrow_named(name, kExpected, value);
  return read;
}

int32_t whole(py::handle value, const std::string& name) {
  constexpr const char* kExpected = "a whole number";
  if (!PyIndex_Check(value.ptr())) throw wrong_type(name, kExpected, value);
  const auto index = py::reinterpret_steal<py::object>(PyNumber_Index(value.ptr()));
  if (!index) rethrow_named(name, kExpected, value);
  int overflow = 0;
  const long long read = PyLong_AsLongLongAndOverflow(index.ptr(), &overflow);
  if (overflow != 0 || read < std::numeric_limits<int32_t>::min() || read > std::numeric_limits<int32_t>::max())
    throw py::value_error(name + " is " + std::string(py::str(index)) + ", which 32 bits do not hold");
  return int32_t(read);
}

bool flag(py::handle value, const std::string& name) {
  constexpr const char* kExpected = "True or False";
  if (is_characters(value) || value.is_none()) throw wrong_type(name, kExpected, value);
  const int read = PyObject_IsTrue(value.ptr());
  if (read < 0) rethrow_named(name, kExpected, value);
  return read != 0;
}

std::string text(py::handle value, const std::string& name) {
  if (!PyUnicode_Check(value.ptr())) throw wrong_type(name, "a str", value);
  const auto bytes =
      py::reinterpret_steal<py::object>(PyUnicode_AsEncodedString(value.ptr(), "utf-8", "surrogateescape"));
  if (!bytes) throw py::error_already_set();
  return bytes_of(bytes, name);
}

std::string file_name(py::handle value, const std::string& name) {
  auto path = py::reinterpret_steal<py::object>(PyOS_FSPath(value.ptr()));
  if (!path) rethrow_named(name, "a str or path", value);
  if (PyBytes_Check(path.ptr())) return bytes_of(path, name);
  path = py::reinterpret_steal<py::object>(PyUnicode_EncodeFSDefault(path.ptr()));
  if (!path) throw py::error_already_set();
  return bytes_of(path, name);
}

std::string text_or_none(py::handle value, const std::string& name) {
  return value.is_none() ? std::string() : text(value, name);
}

std::vector<py::object> items(py::handle values, const std::string& name) {
  constexpr const char* kExpected = "a list";
  if (is_characters(values)) throw wrong_type(name, kExpected, values);
  std::vector<py::object> held;
  if (PySequence_Check(values.ptr()) != 0) {  // by its length: iteration of an object with __getitem__ may have no end
    const Py_ssize_t length = PySequence_Size(values.ptr());
    if (length < 0) rethrow_named(name, kExpected, values);
    for (Py_ssize_t i = 0; i < length; ++i) {
      held.push_back(py::reinterpret_steal<py::object>(PySequence_GetItem(values.ptr(), i)));
      if (!held.back()) throw py::error_already_set();
    }
    return held;
  }
  const auto iterator = py::reinterpret_steal<py::object>(PyObject_GetIter(values.ptr()));
  if (!iterator) rethrow_named(name, kExpected, values);
  while (PyObject* const next = PyIter_Next(iterator.ptr())) held.push_back(py::reinterpret_steal<py::object>(next));
  if (PyErr_Occurred()) throw py::error_already_set();
  return held;
}

std::vector<std::string> texts(py::handle values, const std::string& name) {
  std::vector<std::string> held;
  for (const py::object& value : items(values, name)) held.push_back(text(value, "each of " + name));
  return held;
}

std::vector<std::pair<std::string, py::object>> entries(py::handle values, const std::string& name) {
  if (!PyDict_Check(values.ptr())) throw wrong_type(name, "a dict", values);
  std::vector<std::pair<py::object, py::object>> pairs;
  for (const auto& [key, value] : py::reinterpret_borrow<py::dict>(values))
    pairs.emplace_back(py::reinterpret_borrow<py::object>(key), py::reinterpret_borrow<py::object>(value));
  std::vector<std::pair<std::string, py::object>> held;
  for (const auto& [key, value] : pairs) held.emplace_back(text(key, "a key of " + name), value);
  return held;
}

}  // namespace alabaster::python
