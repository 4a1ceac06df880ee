// Where the instances of an array stand, as the delegate knows it.
#pragma once

#include <cstddef>
#include <optional>

#include "core/math/transform.h"

namespace alabaster {

/// Immutable; any thread. Answers as often as it is asked, so that nothing is held for each instance.
class InstancePlaces {
 public:
  virtual ~InstancePlaces() = default;
  virtual size_t size() const = 0;
  /// Object to world. Empty: this instance is not drawn.
  virtual std::optional<Matrix4d> at(size_t number) const = 0;
  /// True if those in [begin, end), which both have, stand as in `other`, which is of the same kind. For one of them
  /// the answer is exact; for more, false may also mean not known.
  virtual bool stand_alike(const InstancePlaces& other, size_t begin, size_t end) const = 0;
};

}  // namespace alabaster
