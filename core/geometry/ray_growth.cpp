#include "core/geometry/ray_growth.h"

#include <limits>

namespace alabaster {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

}  // namespace

// As Embree inverts, adjoint over determinant, all in float: an under- or overflow here is one there.
RayGrowth RayGrowth::of(const Affine& m) {
  const Vec3f columns[] = {cross(m.y, m.z), cross(m.z, m.x), cross(m.x, m.y)};
  const float determinant = dot(m.x, columns[0]), size = std::abs(determinant);
  if (!(size > 1e-37f && size < 1e37f)) return {kInfinity, kInfinity};
  RayGrowth growth;
  for (const Vec3f& column : columns) {
    const Vec3f c = column * (1 / determinant);
    const float stretch = std::abs(c.x) + std::abs(c.y) + std::abs(c.z), shift = std::abs(dot(m.t, c));
    if (!std::isfinite(stretch) || !std::isfinite(shift)) return {kInfinity, kInfinity};
    growth.include({stretch, shift});
  }
  return growth;
}

// Between two poses the inverse is at most as large as the least stretch allows.
RayGrowth RayGrowth::of(const std::vector<Affine>& poses) {
  const float least = least_stretch_over(poses);
  const float stretch = least > 0 ? 2 / least : kInfinity;
  RayGrowth growth{stretch, 0};
  for (const Affine& pose : poses) {
    growth.include(of(pose));
    growth.shift = std::max(growth.shift, 2 * stretch * max_abs_component(pose.t));
  }
  return std::isfinite(growth.shift) ? growth : RayGrowth{kInfinity, kInfinity};
}

bool is_traceable(const Affine& object_to_world, float distance) {
  return RayGrowth::of(object_to_world).allows(distance, 1);
}

bool is_traceable(const std::vector<Affine>& poses, float distance) {
  return RayGrowth::of(poses).allows(distance, 1);
}

}  // namespace alabaster
