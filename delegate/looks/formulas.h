// What several readers of materials compute alike.
#pragma once

#include <algorithm>
#include <cmath>

#include "delegate/api/scene_types.h"

namespace alabaster::hd::looks {

/// AlabasterDisney's specularColor where the reflectance at normal incidence is 1: of ior 1.5 it is 0.04.
inline constexpr float kSpecularColorOfOne = 25;

/// AlabasterDisney's sheenRoughness 0 is another lobe, Burley's; that of fibres ends here.
inline constexpr float kLeastSheenRoughness = 0.07f;

/// AlabasterDisney's diffuseRoughness whose diffuse lobe is Lambert's within 1 %.
inline constexpr float kLambertRoughness = 0.43f;

/// The mean free path where white light has a colour, in a channel, after a distance > 0. Colour 0 has none, which is
/// Lambert; 1 counts as .999, because a walk must end.
inline double attenuation_path(double color, double distance) {
  return color > 0 ? distance / -std::log(std::clamp(color, 1e-30, 0.999)) : 0;
}

/// Texture coordinates uv' = R (scale uv) + offset, with v up and R counter-clockwise.
struct Placement {
  Vec2f scale{1, 1}, offset{0, 0};
  float angle = 0;  // radians

  bool is_identity() const { return scale == Vec2f(1, 1) && offset == Vec2f(0, 0) && angle == 0; }
  /// False where the result is none of these: uneven scale after a rotation.
  bool multiply(const Vec2f& factor) {
    if (angle != 0 && factor.x != factor.y) return false;
    scale *= factor, offset *= factor;
    return true;
  }
  void rotate(float radians) {
    const float c = std::cos(radians), s = std::sin(radians);
    offset = Vec2f(c * offset.x - s * offset.y, s * offset.x + c * offset.y);
    angle += radians;
  }
};

/// AlabasterTexture's transform is that of glTF, with v down from the image's upper left corner.
inline void place_image(const Placement& placed, MaterialNode* texture) {
  const float c = std::cos(placed.angle), s = std::sin(placed.angle);
  texture->parameters["stScale"] = placed.scale;
  texture->parameters["stRotation"] = placed.angle;
  texture->parameters["stOffset"] =
      Vec2f(placed.offset.x - s * placed.scale.y, 1 - placed.offset.y - c * placed.scale.y);
}

}  // namespace alabaster::hd::looks
