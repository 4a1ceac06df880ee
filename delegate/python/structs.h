// Structs of the C interface made of Python's arguments. Each holds what its struct points at. Internal to this room.
#pragma once

#include <optional>

#include "delegate/python/values.h"

namespace alabaster::python {

/// Pixels, 0 or more.
int32_t length_of(py::handle value, const std::string& name);
/// Four whole numbers; None: an empty one.
AlabasterRect rect_of(py::handle value, const std::string& name);

/// Tokens from a sequence of texts; None gives no value.
class Tokens {
 public:
  Tokens() = default;
  Tokens(py::handle texts, const std::string& name);
  /// For one call, during which this lives.
  AlabasterValue pass() const;

 private:
  bool given_ = false;
  std::vector<std::string> held_;
  mutable std::vector<const char*> raw_;
};

}  // namespace alabaster::python
