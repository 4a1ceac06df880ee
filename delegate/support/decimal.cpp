#include "delegate/support/decimal.h"

#include <charconv>

namespace alabaster::hd::support {

double shortest_decimal(float value) {
  char text[64];
  const auto end = std::to_chars(text, text + sizeof text, value);
  double read = 0;
  std::from_chars(text, end.ptr, read);
  return read;
}

}  // namespace alabaster::hd::support
