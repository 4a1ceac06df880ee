// Values of the contract to and from members of core's structs, through the rows of core's tables of parameters.
#pragma once

#include <array>
#include <cmath>

#include "core/parameter/parameter.h"
#include "delegate/api/types.h"

namespace alabaster::hd::support {

enum class ParameterFault { none, type, range };

/// A number that fits `minimum`..`maximum`, or the nearest that does.
ParameterFault read_number(const Value& value, double minimum, double maximum, double* out);
ParameterFault read_color(const Value& value, double minimum, double maximum, Rgb* out);
/// A vector of as many numbers.
template <class Vector>
ParameterFault read_vector(const Value& value, Vector* out) {
  std::array<double, 4> given{};
  if (value.components(&given) != Vector::dimensions()) return ParameterFault::type;
  for (unsigned i = 0; i < Vector::dimensions(); ++i) (*out)[int(i)] = static_cast<float>(given[i]);
  return ParameterFault::none;
}

/// Sets the row's member of `object`; leaves it as it is if the value is of the wrong type.
template <class T, class... Words>
ParameterFault set_parameter(const Parameter<T, Words...>& row, const Value& value, T* object) {
  return std::visit(
      [&](auto member) {
        auto& out = object->*member;
        using Member = std::decay_t<decltype(out)>;
        if constexpr (std::is_same_v<Member, Rgb>) {
          return read_color(value, row.minimum, row.maximum, &out);
        } else if constexpr (requires { Member::dimensions(); }) {
          return read_vector(value, &out);
        } else if constexpr (std::is_enum_v<Member>) {
          const std::string word = value.text_or("");
          for (size_t i = 0; i < row.words.size() && row.words[i]; ++i)
            if (word == row.words[i]) return out = static_cast<Member>(i), ParameterFault::none;
          return ParameterFault::type;
        } else {
          constexpr bool kSwitch = std::is_same_v<Member, bool>;  // 0 is off, all else on
          double read = 0;
          const ParameterFault fault = read_number(value, row.minimum, row.maximum, &read);
          if (std::is_integral_v<Member> && !kSwitch && read != std::floor(read)) return ParameterFault::type;
          if (fault != ParameterFault::type) out = kSwitch ? read != 0 : static_cast<Member>(read);
          return fault;
        }
      },
      row.member);
}

template <class T, class... Words>
Value get_parameter(const Parameter<T, Words...>& row, const T& object) {
  return std::visit(
      [&](auto member) -> Value {
        const auto& held = object.*member;
        using Member = std::decay_t<decltype(held)>;
        if constexpr (std::is_same_v<Member, Rgb>)
          return Vec3f(held.r, held.g, held.b);
        else if constexpr (std::is_enum_v<Member>)
          return std::string(row.words[static_cast<size_t>(held)]);
        else if constexpr (std::is_same_v<Member, uint32_t>)
          return static_cast<int64_t>(held);
        else
          return held;
      },
      row.member);
}

}  // namespace alabaster::hd::support
