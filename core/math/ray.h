#pragma once

#include <limits>

#include "core/math/vector.h"

namespace alabaster {

/// Points org + t * dir for t in [0, tmax]. dir need not be unit: t is in units of |dir|. `time` is that of
/// the shutter, 0..1; things that stand still do not ask for it.
struct Ray {
  Vec3f org{0, 0, 0};
  Vec3f dir{0, 0, 1};
  float tmax = std::numeric_limits<float>::infinity();
  float time = 0;
};

}  // namespace alabaster
