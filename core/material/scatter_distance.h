// The scale between scatter distance and mean free path: Chiang, Kutz, Burley 2016, eq. 2 and 3.
#pragma once

#include <algorithm>

namespace alabaster {

inline double clamp_albedo(double albedo) {
  return albedo > 0 ? std::min(albedo, 1.0) : 0;  // NaN too
}

/// Eq. 2: s = 1.9 - A + 3.5 (A - 0.8)^2.
inline double distance_scale(double albedo) {
  const double a = clamp_albedo(albedo);
  return 1.9 - a + 3.5 * (a - 0.8) * (a - 0.8);
}

}  // namespace alabaster
