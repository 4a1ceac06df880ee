// Tables of parameters. A row names a member of a struct and says which values it may have. Reading, printing, glTF's
// names and the tests against schemas/*.json all go through the rows, so a parameter's name and range stand once. The
// struct's initialisers are the defaults.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <variant>

#include "core/color/rgb.h"

namespace alabaster {

/// `Words`: the enumerations among T's members.
template <class T, class... Words>
struct Parameter {
  const char* name = "";  // in the schema, and for users
  std::variant<float T::*, bool T::*, uint32_t T::*, Rgb T::*, Words T::*...> member;
  double minimum = -std::numeric_limits<double>::infinity();  // of a number, and of each channel of a colour
  double maximum = std::numeric_limits<double>::infinity();
  std::array<const char*, 5> words{};  // of an enumeration, in its order; null: no more

  constexpr bool is_color() const { return std::holds_alternative<Rgb T::*>(member); }
};

inline constexpr double kUnbounded = std::numeric_limits<double>::infinity();

}  // namespace alabaster
