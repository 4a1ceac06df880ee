// Python's values as the C interface's. Internal to this room.
#pragma once

#include "delegate/c_api/alabaster.hpp"
#include "delegate/python/arguments.h"

namespace alabaster::python {

using c_api::Value;

/// A number in memory. Kind: f real, i signed, u unsigned, 0 no number in the machine's order.
struct Element {
  char kind = 0;
  size_t bytes = 0;
};
/// The elements of a value of a type of the C interface. No components: it has no numbers.
struct Elements {
  Element of;
  size_t components = 0;
  size_t bytes() const { return of.bytes * components; }
};
Elements elements_of(int32_t type);
double real_at(const char* at, const Element& element);
/// Beyond 63 bits: the largest number, which no array takes either.
int64_t integer_at(const char* at, const Element& element);

// `name` is that of the argument, for errors.

/// A parameter: None, bool, int, float, str or path, two to four numbers, a 4 x 4 matrix, or an array.
Value parameter(py::handle value, const std::string& name);
/// Four numbers each.
Value planes(py::handle values, const std::string& name);
c_api::Parameters parameters(py::handle values, const std::string& name);

/// Elements of `type` (ALABASTER_INT, FLOAT, FLOAT2, ..., MATRIX) from an array or nested sequences. An array of
/// contiguous float32 (int32, float64 for matrices) is lent, as one that the host edits if it can be written to; others
/// are converted. None gives no value.
Value array(int32_t type, py::handle values, const std::string& name);
/// The type of the elements by the shape: (n) int or float, (n, 2), (n, 3), (n, 4), (n, 4, 4).
Value array_by_shape(py::handle values, const std::string& name);
/// The length of each axis.
std::vector<size_t> shape_of(py::handle values, const std::string& name);

/// None: the identity.
std::array<double, 16> matrix(py::handle values, const std::string& name);

/// Gives back what the library has returned since the last call: it may be returned by any thread, and Python's memory
/// is freed by threads that hold its lock.
void free_returned();
/// For the child of a fork: no other thread holds the list of what was returned.
void forget_returning_threads();

/// For py::call_guard: gives back what the call's arguments lent, however the call ends.
struct FreeReturned {
  FreeReturned() = default;
  ~FreeReturned() { free_returned(); }
  FreeReturned(const FreeReturned&) = delete;
  FreeReturned& operator=(const FreeReturned&) = delete;
};

}  // namespace alabaster::python
