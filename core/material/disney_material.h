// A material as the scene holds it: each parameter a constant, times textures. The table of all its parameters.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/material/disney_parameters.h"
#include "core/material/displacement.h"
#include "core/material/texture_lookup.h"
#include "core/parameter/parameter.h"

namespace alabaster {

/// The meaning of an image's texels.
enum class Texels { colors, numbers };

/// One row for each parameter of the surface node AlabasterDisney, in the order of schemas/disney_material.json.
struct MaterialParameter : Parameter<DisneyParameters, Sides, OpacityMode> {
  Texels texels = Texels::numbers;  // numbers are read without conversion
  /// Colours and numbers can be textured; switches cannot.
  constexpr bool is_textured() const { return is_color() || std::holds_alternative<float DisneyParameters::*>(member); }
};
std::span<const MaterialParameter> material_parameters();
/// Null if there is none of that name.
const MaterialParameter* find_material_parameter(std::string_view name);

/// Converts the constant of a colour, and clamps it to the parameter's range.
void convert_color(const MaterialParameter& row, const RgbMatrix& matrix, DisneyParameters* p);

/// A texture, and the parameters that it multiplies.
struct MaterialTexture {
  struct Use {
    const MaterialParameter* parameter;  // of material_parameters()
    Channel channel = Channel::rgb;      // rgb: of a colour alone
  };
  TextureLookup lookup;
  std::vector<Use> uses;
};

struct DisneyMaterial {
  std::string name;
  DisneyParameters constants;  // within the ranges of material_parameters()
  std::vector<MaterialTexture> textures;
  std::optional<NormalMap> normal_map;       // value: the normal in tangent space, of any length; or a height
  std::optional<NormalMap> coat_normal_map;  // of the coat; without it the coat has the mesh's normal
  std::optional<Displacement> displacement;  // meshes are displaced before a snapshot is compiled of them

  /// Once constants and textures are set. A transparent surface is a clear sheet; a threshold cuts it out instead.
  void settle_opacity_mode();

  /// Reads each texture once. Products are clamped to the parameter's range; where one is not finite it becomes the
  /// parameter's default. A mean free path gives its scatter distance.
  void evaluate(const HitPrimvars& at, DisneyParameters* p) const;
  DisneyParameters evaluate(const HitPrimvars& at) const {
    DisneyParameters p;
    return evaluate(at, &p), p;
  }
  /// True if a texture multiplies the parameter.
  bool varies(Rgb DisneyParameters::*parameter) const;
  bool varies(float DisneyParameters::*parameter) const;
  std::vector<const Texture*> images() const;
  /// The primvars that are read without an image.
  std::vector<UvSetName> primvars() const;
  /// True if it reads the primvar, also as coordinates of an image.
  bool reads(const UvSetName& primvar) const;
  /// False only if no texel can scatter: a body of this material is no medium.
  bool scatters() const {
    const DisneyParameters& p = constants;
    return !p.thin && (p.subsurface_weight > 0 || p.spec_trans > 0) &&
           (max_component(p.scatter_distance) > 0 || max_component(p.mean_free_path) > 0);
  }
  /// Parts of a surface that scatters may have no subsurface lobe.
  bool is_partly_closed() const;
  /// A texture changes the medium's albedo.
  bool varies_albedo() const;
  /// False only if no texel lets light through.
  bool transmits() const { return constants.transmits(); }
  bool emits() const { return !is_black(constants.emission); }
  /// Light may go on behind the surface: then its back is there whether or not the mesh is double-sided.
  bool is_translucent() const { return scatters() || transmits(); }
  bool is_partly_opaque() const;
  /// The share of the surface that is there: its opacity, or 0 or 1 by its threshold.
  float coverage(const HitPrimvars& at) const;
};

}  // namespace alabaster
