// Inverses of the warps of core/sampling/warp.h: the u that a warp took a value from.
#pragma once

#include "core/math/vector.h"

namespace alabaster::testing {

Vec2f invert_concentric_disk(const Vec2f& d);
inline Vec2f invert_cosine_hemisphere(const Vec3f& w) {
  return invert_concentric_disk({w.x, w.y});
}
Vec2f invert_uniform_sphere(const Vec3f& w);
Vec2f invert_uniform_cone(const Vec3f& w, float one_minus_cos_max);
Vec2f invert_uniform_triangle(const Vec2f& b);

}  // namespace alabaster::testing
