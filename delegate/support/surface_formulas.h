// What several readers of materials compute alike.
#pragma once

#include <cmath>

#include "delegate/api/scene_types.h"

namespace alabaster::hd::support {

/// AlabasterDisney's specularColor where the reflectance at normal incidence is 1: of ior 1.5 it is 0.04.
inline constexpr float kSpecularColorOfOne = 25;

/// Places an image at uv' = R (scale uv) + offset, with v up and R counter-clockwise. AlabasterTexture's transform is
/// that of glTF, with v down from the image's upper left corner.
inline void place_image(const Vec2f& scale, float radians, const Vec2f& offset, MaterialNode* texture) {
  const float c = std::cos(radians), s = std::sin(radians);
  texture->parameters["stScale"] = scale;
  texture->parameters["stRotation"] = radians;
  texture->parameters["stOffset"] = Vec2f(offset.x - s * scale.y, 1 - offset.y - c * scale.y);
}

}  // namespace alabaster::hd::support
