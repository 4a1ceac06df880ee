// Numbers of dictionaries and of parameters, by name.
#pragma once

namespace alabaster::hd::support {

/// The number of that name in a map of Values; `fallback` where there is none.
template <class Map>
double number_in(const Map& values, const char* name, double fallback = 0) {
  const auto found = values.find(name);
  return found == values.end() ? fallback : found->second.number_or(fallback);
}

}  // namespace alabaster::hd::support
