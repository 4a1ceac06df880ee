#include "delegate/support/parameters.h"

#include <array>

namespace alabaster::hd::support {

ParameterFault read_number(const Value& value, double minimum, double maximum, double* out) {
  const double number = value.number_or(std::numeric_limits<double>::quiet_NaN());
  if (std::isnan(number)) return ParameterFault::type;
  constexpr double kLargest = std::numeric_limits<float>::max();
  *out = std::clamp(number, std::max(minimum, -kLargest), std::min(maximum, kLargest));
  return *out == number ? ParameterFault::none : ParameterFault::range;
}

ParameterFault read_color(const Value& value, double minimum, double maximum, Rgb* out) {
  std::array<double, 3> c{};
  std::array<double, 4> given{};
  if (value.components(&given) >= 3)
    c = {given[0], given[1], given[2]};
  else
    c.fill(value.number_or(std::numeric_limits<double>::quiet_NaN()));
  ParameterFault fault = ParameterFault::none;
  std::array<double, 3> read{};
  for (size_t i = 0; i < 3; ++i) {
    const ParameterFault f = read_number(c[i], minimum, maximum, &read[i]);
    if (f == ParameterFault::type) return f;
    if (f == ParameterFault::range) fault = f;
  }
  *out = Rgb(static_cast<float>(read[0]), static_cast<float>(read[1]), static_cast<float>(read[2]));
  return fault;
}

}  // namespace alabaster::hd::support
