// Structs of the C door made of Python's arguments. Each holds what its struct points at. Internal to this room.
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

/// Values at times in frames: [(time, value), ...]. None: no motion.
class Motion {
 public:
  Motion() = default;
  /// Arrays of elements of `type`.
  static Motion of_arrays(py::handle samples, int32_t type, const std::string& name);
  static Motion of_transforms(py::handle samples, const std::string& name);
  /// For one call, during which this lives.
  AlabasterMotion pass() const;

 private:
  std::vector<double> times_;
  std::vector<Value> values_;
  mutable std::vector<AlabasterValue> raw_;

  template <class Read>
  static Motion read(py::handle samples, const std::string& name, const Read& value_of);
};

class Camera {
 public:
  /// transform, motion, and parameters by name.
  explicit Camera(py::handle options);
  /// For one call, during which this lives.
  AlabasterCamera pass() const;

 private:
  std::array<double, 16> transform_{};
  Motion motion_;
  door::Parameters parameters_;
  mutable std::vector<AlabasterParameter> raw_;
};

}  // namespace alabaster::python
