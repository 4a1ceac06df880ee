// Structs of the C door made of Python's arguments. Each holds what its struct points at. Internal to this room.
#pragma once

#include <optional>

#include "delegate/python/values.h"

namespace alabaster::python {

/// Tokens from a sequence of texts; None gives no value.
class Tokens {
 public:
  Tokens() = default;
  explicit Tokens(py::handle texts);
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
  static Motion of_arrays(py::handle samples, int32_t type, const char* name);
  static Motion of_transforms(py::handle samples);
  /// For one call, during which this lives.
  AlabasterMotion pass() const;

 private:
  std::vector<double> times_;
  std::vector<Value> values_;
  mutable std::vector<AlabasterValue> raw_;

  template <class Read>
  static Motion read(py::handle samples, const Read& value_of);
};

class Camera {
 public:
  /// transform, motion, and parameters by name.
  explicit Camera(const py::dict& options);
  /// For one call, during which this lives.
  AlabasterCamera pass() const;

 private:
  std::array<double, 16> transform_;
  Motion motion_;
  door::Parameters parameters_;
  mutable std::vector<AlabasterParameter> raw_;
};

}  // namespace alabaster::python
