// printf for texts of this library, with a decimal point whatever the host's locale is.
#pragma once

#include <locale.h>

#include <cstdio>
#include <string>

namespace alabaster {

/// At most 255 bytes.
template <class... Numbers>
std::string plain_format(const char* text, Numbers... numbers) {
  static const locale_t plain = newlocale(LC_ALL_MASK, "C", nullptr);
  char buffer[256];
  const locale_t before = uselocale(plain);  // of this thread alone
  std::snprintf(buffer, sizeof buffer, text, numbers...);
  uselocale(before);
  return buffer;
}

}  // namespace alabaster
