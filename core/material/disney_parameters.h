// The Disney BSDF's parameters as plain numbers, as the lobes see them after texturing.
// Names and ranges: material_parameters(). Meanings: schemas/disney_material.json (Burley 2012 and 2015).
#pragma once

#include <algorithm>
#include <cstdint>

#include "core/color/rgb.h"
#include "core/math/vector.h"

namespace alabaster {

/// The sides of a surface that are there: as the mesh says, its front, or both.
enum class Sides : uint8_t { mesh, front, both };

/// What the share 1 - opacity of a surface is: not there, or clear below the highlight and the layers of a thin sheet.
enum class OpacityMode : uint8_t { presence, transparent };

struct DisneyParameters {
  Rgb base_color{0.8f};
  float metallic = 0;
  float roughness = 0.5f;
  float diffuse_roughness = -1;  // of the retro-reflection; below 0: roughness
  float anisotropic = 0;
  float anisotropic_rotation = 0;  // in turns; the integrator turns the local frame, no lobe reads it
  float specular_tint = 0;
  float ior = 1.5f;          // of the dielectric specular lobe
  float specular = 1;        // scales dielectric F0 (KHR_materials_specular's specularFactor); 1: by ior alone
  Rgb specular_color{1.0f};  // tints dielectric F0 (KHR_materials_specular)
  float sheen = 0;
  float sheen_tint = 0.5f;
  Rgb sheen_color{1.0f};
  float sheen_roughness = 0;  // > 0: fibres of this roughness in place of Burley's sheen
  float clearcoat = 0;
  float clearcoat_gloss = 1;
  float coat = 0;  // > 0: a clear layer over everything, in place of the clearcoat
  float coat_roughness = 0;
  float coat_ior = 1.5f;
  Rgb coat_color{1.0f};      // of white light that is reflected below the coat
  float coat_darkening = 0;  // share of the light that the coat sends back to what lies below
  /// Unit normals of the coat and of the surface in the local frame. Not rows of the table: the integrator sets them at
  /// a hit.
  Vec3f coat_normal{0, 0, 1}, surface_normal{0, 0, 1};
  Rgb scatter_distance{0.0f};    // per channel, scene units; 0: Lambert in that channel
  float scatter_anisotropy = 0;  // Henyey-Greenstein g of the scattering below the surface
  Rgb mean_free_path{0.0f};      // per channel, scene units; > 0: scatter_distance follows from it
  float subsurface_weight = 1;   // of medium_albedo() in the opaque dielectric base; the rest is base_color
  Rgb subsurface_color{-1.0f};   // the medium's albedo; below 0 in all channels: base_color
  Rgb emission{0.0f};            // radiance
  float opacity = 1;             // the share of the surface that is there
  float opacity_threshold = 0;   // > 0: present where opacity reaches it, nowhere else
  float spec_trans = 0;          // share of the dielectric base that refracts instead of scattering
  bool thin = false;             // the surface is a sheet without an interior
  Sides sides = Sides::mesh;     // no lobe reads it
  OpacityMode opacity_mode = OpacityMode::presence;
  float flatness = 0;                 // thin only: towards a flatter diffuse reflection
  float diff_trans = 0;               // 1: half of the diffuse light leaves on the other side; 2: all of it
  Rgb diff_trans_color{0.8f};         // of that light
  Rgb attenuation_color{1.0f};        // white light has this colour after attenuation_distance inside
  float attenuation_distance = 0;     // scene units; 0: the interior absorbs nothing
  uint32_t priority = 0;              // where interiors overlap the highest counts
  float dispersion = 0;               // 20 over the Abbe number of the clear interior
  float iridescence = 0;              // share of the surface under a thin film
  float iridescence_ior = 1.3f;       // of the film
  float iridescence_thickness = 400;  // of the film, in nanometres
  /// Glossy lobes are at least as rough; the diffuse lobe keeps `roughness`. Not a row of the table: the integrator
  /// sets it (IntegratorSettings::glossy_filter).
  float least_roughness = 0;

  /// Once evaluated.
  bool has_medium() const { return !thin && max_component(scatter_distance) > 0; }
  /// Light enters a medium here: by the subsurface lobe, or through the clear share.
  bool scatters() const { return has_medium() && (subsurface_weight > 0 || spec_trans > 0); }
  bool has_own_albedo() const { return max_component(subsurface_color) >= 0; }
  Rgb medium_albedo() const {
    const Rgb& own = subsurface_color;
    return has_own_albedo() ? Rgb(std::max(own.r, 0.0f), std::max(own.g, 0.0f), std::max(own.b, 0.0f)) : base_color;
  }
  /// The opaque dielectric base is a mixture of the two.
  bool is_mixed() const { return !thin && subsurface_weight > 0 && (subsurface_weight < 1 || has_own_albedo()); }
  /// The colour of the dielectric base; its clear share has base_color.
  Rgb mixed_color() const {
    return is_mixed() ? lerp(base_color, medium_albedo(), subsurface_weight * (1 - spec_trans)) : base_color;
  }
  /// scatter_distance of a walk with that mean free path, in the channels that have one.
  void take_mean_free_path();
  float retro_roughness() const { return diffuse_roughness >= 0 ? diffuse_roughness : roughness; }
  bool is_widened() const { return least_roughness > roughness; }
  float specular_roughness() const { return std::max(roughness, least_roughness); }

  /// A coat or fibres, which dim what lies below them.
  bool has_dimming_layers() const { return coat > 0 || (sheen > 0 && sheen_roughness > 0); }

  /// Once settled: a sheet whose clear share lets light pass straight on, untinted, below full specular and layers.
  bool is_transparent() const { return opacity_mode == OpacityMode::transparent; }

  /// Light may go through the surface into an interior, or through the sheet.
  bool transmits() const { return spec_trans > 0 || diff_trans > 0; }
};

}  // namespace alabaster
