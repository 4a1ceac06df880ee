// Python's values as the C door's. Internal to this room.
#pragma once

#include <pybind11/pybind11.h>

#include "delegate/c_api/alabaster.hpp"

namespace alabaster::python {

namespace py = pybind11;
using door::Value;

/// A parameter: None, bool, int, float, str or path, two to four numbers, or a 4 x 4 matrix.
Value parameter(py::handle value);
door::Parameters parameters(const py::dict& values);

/// Elements of `type` (ALABASTER_INT, FLOAT, FLOAT2, ..., MATRIX) from an array or nested sequences. An array of
/// contiguous float32 (int32, float64 for matrices) is lent, as one that the host edits if it can be written to; others
/// are converted. None gives no value.
Value array(int32_t type, py::handle values, const char* name);
/// The type of the elements by the shape: (n) int or float, (n, 2), (n, 3), (n, 4), (n, 4, 4).
Value array_by_shape(py::handle values, const char* name);
/// The length of each axis.
std::vector<size_t> shape_of(py::handle values);

/// None: the identity.
std::array<double, 16> matrix(py::handle values);

py::object to_python(const AlabasterValue& value);

/// Gives back what the library has returned since the last call: it may be returned by any thread, and Python's memory
/// is freed by threads that hold its lock.
void free_returned();

}  // namespace alabaster::python
