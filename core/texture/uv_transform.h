// Placement of an image on texture coordinates.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "core/math/vector.h"

namespace alabaster {

/// uv' = offset + R (scale * uv) with R = (cos, sin; -sin, cos), which acts on v DOWN (KHR_texture_transform). v up
/// here is 1 - v down there, before and after.
class UvTransform {
 public:
  UvTransform() = default;
  /// `rotation` in radians, counter-clockwise as the image is seen.
  UvTransform(const Vec2f& offset, float rotation, const Vec2f& scale) {
    const float c = std::cos(rotation), s = std::sin(rotation);
    // With d = 1 - v: u' = ox + c sx u + s sy d, 1 - v' = oy - s sx u + c sy d.
    u_ = {c * scale.x, -s * scale.y, offset.x + s * scale.y};
    v_ = {s * scale.x, c * scale.y, 1 - offset.y - c * scale.y};
  }
  Vec2f operator()(const Vec2f& uv) const {
    return {u_.x * uv.x + u_.y * uv.y + u_.z, v_.x * uv.x + v_.y * uv.y + v_.z};
  }
  /// The change of u' and of v' per unit of u and v.
  std::array<Vec2f, 2> axes() const { return {Vec2f(u_.x, u_.y), Vec2f(v_.x, v_.y)}; }
  /// How far a footprint reaches in an image: its width, of a length for which `metric` (xx, xy, yy) is the squared
  /// rate of change of uv, in texels of an image of this size, along the direction in which it covers the fewest.
  float texels_across(float width, const Vec3f& metric, const Vec2f& size) const {
    const Vec2f u = Vec2f(u_.x, u_.y) * size.x, v = Vec2f(v_.x, v_.y) * size.y;
    const auto product = [&](const Vec2f& a, const Vec2f& b) {
      return a.x * b.x * metric.x + (a.x * b.y + a.y * b.x) * metric.y + a.y * b.y * metric.z;
    };
    const float uu = product(u, u), uv = product(u, v), vv = product(v, v);
    // The smaller eigenvalue.
    const float trace = uu + vv, determinant = uu * vv - uv * uv;
    const float root = trace + std::sqrt(std::max(trace * trace - 4 * determinant, 0.0f));
    return root > 0 ? width * std::sqrt(std::max(2 * determinant / root, 0.0f)) : 0;
  }
  bool operator==(const UvTransform&) const = default;

 private:
  Vec3f u_{1, 0, 0}, v_{0, 1, 0};
};

}  // namespace alabaster
