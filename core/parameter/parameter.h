// Tables of parameters. A row names a member of a struct, says which values it may have, and has the words of its
// documentation. Reading, printing, glTF's names and schemas/*.json are made from the rows, so that a parameter's name,
// range and meaning stand once. The struct's initialisers are the defaults.
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
  const char* unit = "";
  const char* text = "";  // a sentence or two
  /// Lights: a bit for each LightType that has the parameter, or 0 for all. Cameras: kMillimetres, or 0.
  /// Settings: bits of setting_use.
  uint32_t of = 0;

  constexpr bool is_color() const { return std::holds_alternative<Rgb T::*>(member); }
};

/// A length in scene units. Files that give it in millimetres are converted when they are read.
inline constexpr uint32_t kMillimetres = 1;

inline constexpr double kUnbounded = std::numeric_limits<double>::infinity();

}  // namespace alabaster
