// A material as the scene holds it: each parameter a constant or an image. The table of all its parameters.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/material/disney_parameters.h"
#include "core/parameter/parameter.h"
#include "core/texture/texture.h"

namespace alabaster {

struct DisneyMaterial {
  std::string name;
  DisneyParameters constants;  // within the ranges of material_parameters()
  // Each multiplies its constant; null: none.
  std::shared_ptr<const Texture> base_color_map;
  std::shared_ptr<const Texture> scatter_distance_map;

  /// Reads each texture once. The product is clamped to the parameter's range; where it is not finite it becomes the
  /// parameter's default.
  DisneyParameters evaluate(const Vec2f& uv) const;
  std::vector<const Texture*> textures() const;
  /// False only if no texel can scatter.
  bool scatters() const { return constants.scatters(); }
  bool emits() const { return !is_black(constants.emission); }
};

/// The meaning of an image's texels.
enum class Texels { colors, numbers };

/// One row for each parameter of the surface node AlabasterDisney, in the order of schemas/disney_material.json.
struct MaterialParameter : Parameter<DisneyParameters> {
  std::shared_ptr<const Texture> DisneyMaterial::*map = nullptr;  // null: it cannot be textured
  Texels texels = Texels::numbers;                                // numbers are read without conversion
};
std::span<const MaterialParameter> material_parameters();

}  // namespace alabaster
