// A material as the scene holds it: each parameter a constant or an image.
#pragma once

#include <string>

#include "core/material/disney_parameters.h"
#include "core/texture/texture.h"

namespace alabaster {

struct DisneyMaterial {
  std::string name;
  DisneyParameters constants;                     // already clamped
  std::shared_ptr<const Texture> base_color_map;  // multiplies constants.base_color; null: none

  /// Reads each texture once. The result is clamped.
  DisneyParameters evaluate(const Vec2f& uv) const;
  bool scatters() const { return constants.scatters(); }
  bool emits() const { return !is_black(constants.emission); }
};

}  // namespace alabaster
