#include "core/material/disney_material.h"

namespace alabaster {

DisneyParameters DisneyMaterial::evaluate(const Vec2f& uv) const {
  if (!base_color_map && !scatter_distance_map) return constants;
  DisneyParameters p = constants;
  if (base_color_map) p.base_color *= base_color_map->rgb(uv);
  if (scatter_distance_map) p.scatter_distance *= scatter_distance_map->rgb(uv);
  return clamp_to_ranges(p);
}

}  // namespace alabaster
