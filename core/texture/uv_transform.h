// Placement of an image on texture coordinates.
#pragma once

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
  bool operator==(const UvTransform&) const = default;

 private:
  Vec3f u_{1, 0, 0}, v_{0, 1, 0};
};

}  // namespace alabaster
