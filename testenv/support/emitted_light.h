// The light of all lights that a ray meets.
#pragma once

#include "core/light/light_set.h"

namespace alabaster::testing {

template <class Weigh>
Rgb emitted_light(const LightSet& set, const Ray& ray, bool escaped, bool camera_ray, const LightSampleContext& search,
                  const Weigh& weigh, float tmin = 0, const LobeShares* shares = nullptr) {
  Rgb sum(0.0f);
  set.each_emitted(ray, escaped, camera_ray, search, weigh, tmin, shares,
                   [&](size_t, const Rgb& light) { sum += light; });
  return sum;
}

}  // namespace alabaster::testing
