// A material as the scene holds it: each parameter a constant or an image.
#pragma once

#include <string>

#include "core/material/disney_parameters.h"
#include "core/texture/texture.h"

namespace alabaster {

struct DisneyMaterial {
  std::string name;
  DisneyParameters constants;  // already clamped
  // Each multiplies its constant; null: none.
  std::shared_ptr<const Texture> base_color_map;
  std::shared_ptr<const Texture> scatter_distance_map;  // numbers, not a colour: read without conversion

  /// Reads each texture once. The result is clamped.
  DisneyParameters evaluate(const Vec2f& uv) const;
  /// False only if no texel can scatter.
  bool scatters() const { return constants.scatters(); }
  bool emits() const { return !is_black(constants.emission); }
};

}  // namespace alabaster
