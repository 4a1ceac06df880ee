// Python's arguments as numbers, texts and lists of C++. Every function takes the name of the argument for its errors,
// which are Python's: TypeError for another type, ValueError for a value out of range, and errors of the host's code.
// Internal to this room.
#pragma once

#include <pybind11/pybind11.h>

#include <concepts>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace alabaster::python {

namespace py = pybind11;

/// "str", "numpy.ndarray" and the like.
std::string type_name(py::handle value);
py::type_error wrong_type(const std::string& name, const char* expected, py::handle value);

/// str, bytes, bytearray: sequences to Python, but never numbers or lists here.
bool is_characters(py::handle value);
/// str or os.PathLike.
bool is_text(py::handle value);

double number(py::handle value, const std::string& name);
/// Floats are refused, also whole ones.
int32_t whole(py::handle value, const std::string& name);
bool flag(py::handle value, const std::string& name);
/// A str without zero characters.
std::string text(py::handle value, const std::string& name);
/// str, bytes or os.PathLike without zero characters.
std::string file_name(py::handle value, const std::string& name);
/// "" for None.
std::string text_or_none(py::handle value, const std::string& name);

/// The elements of an iterable. The host's code may change it at any time: nothing points into it.
std::vector<py::object> items(py::handle values, const std::string& name);
std::vector<std::string> texts(py::handle values, const std::string& name);
/// The entries of a dict, whose keys are texts.
std::vector<std::pair<std::string, py::object>> entries(py::handle values, const std::string& name);

/// An object of this module.
template <class T>
T& object_of(py::handle value, const std::string& name, const char* type) {
  if (!py::isinstance<T>(value)) throw wrong_type(name, type, value);
  return value.cast<T&>();
}

/// A text of a function's argument, without zero characters.
struct Text : std::string {
  using std::string::string;
};

/// A text that is not empty.
struct PrimPath : Text {};

}  // namespace alabaster::python

template <std::derived_from<alabaster::python::Text> T>
struct pybind11::detail::type_caster<T> {
  PYBIND11_TYPE_CASTER(T, const_name("str"));
  bool load(handle source, bool) {
    constexpr bool kIsPath = std::is_same_v<T, alabaster::python::PrimPath>;
    if (!PyUnicode_Check(source.ptr())) return false;
    value.assign(alabaster::python::text(source, kIsPath ? "a path" : "a text"));
    if (kIsPath && value.empty()) throw value_error("the path is empty");
    return true;
  }
};
