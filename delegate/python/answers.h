// Answers of the library as Python's values. Internal to this room.
#pragma once

#include <pybind11/pybind11.h>

#include <string>
#include <utility>
#include <vector>

#include "delegate/c_api/alabaster.h"

namespace alabaster::python {

namespace py = pybind11;

/// A copy of a value, made in a callback: callbacks run without Python's lock, and Python code that they ran could call
/// the library again.
class Answer {
 public:
  Answer() = default;
  explicit Answer(const AlabasterValue& value);
  py::object to_python() const;

 private:
  int32_t type_ = ALABASTER_NONE;
  bool is_array_ = false;
  size_t count_ = 0;
  std::vector<char> numbers_;
  std::vector<std::string> texts_;
  std::vector<std::pair<std::string, Answer>> entries_;
};

/// By name, in the order in which they were told.
using Answers = std::vector<std::pair<std::string, Answer>>;
/// For an AlabasterVisit, with the Answers as `user`.
void keep_answer(void* user, const char* name, const AlabasterValue* value);

/// Names of prims and files: bytes that are no UTF-8 come back as they were given.
py::str name_to_python(const std::string& name);
/// Messages: bytes that are no UTF-8 are escaped, so that they can be printed.
py::str message_to_python(const std::string& text);

}  // namespace alabaster::python
