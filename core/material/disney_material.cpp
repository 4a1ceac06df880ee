#include "core/material/disney_material.h"

namespace alabaster {

DisneyParameters DisneyMaterial::evaluate(const Vec2f& uv) const {
  if (!base_color_map) return constants;
  DisneyParameters p = constants;
  p.base_color *= base_color_map->rgb(uv);
  return clamp_to_ranges(p);
}

}  // namespace alabaster
