#include "delegate/looks/look_tables.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/material/disney_parameters.h"
#include "core/material/microfacet.h"
#include "delegate/looks/formulas.h"

namespace alabaster::hd::looks {

Vec3f Terms::color(size_t i) const {
  if (signals_[i].is_textured())
    tell_(std::string("a texture of ") + inputs_[i].name + " is not read; its constant is used");
  return signals_[i].rgb();
}

Signal product_of(const Terms& in) {
  Signal all = signal_of(in.factor());
  for (size_t i = 0; i < in.size(); ++i) {
    auto next = product(all, in[i]);
    if (!next) in.tell("too many textures are multiplied; some are left out");
    if (next) all = std::move(*next);
  }
  return all;
}

Signal normals_of(const Terms& in) {
  return in[0];
}

namespace {

bool is_on(float value) {
  return value != 0;
}

Signal quotient(const Terms& in) {
  const float by = in.number(1);
  return by > 0 ? affine(in[0], Vec4f(in.factor() / by), Vec4f(0)).value() : signal_of(0.0f);
}

// 20 over the Abbe number, where 0 says that there is no dispersion.
Signal inverse(const Terms& in) {
  const float number = in.number(0);
  return signal_of(number > 0 ? in.factor() / number : 0);
}

Signal sheen_roughness(const Terms& in) {
  if (in[0].is_textured()) return in[0];
  return signal_of(std::max(in[0].constant.x, kLeastSheenRoughness));
}

Signal is_positive(const Terms& in) {
  return signal_of(in[0].is_used() ? 1.0f : 0.0f);
}

Signal mean(const Terms& in) {
  if (in[0].is_textured()) return in[0];
  const Vec3f c = in[0].rgb();
  if (c.x != c.y || c.y != c.z) in.tell("a coloured opacity is drawn as its mean");
  return signal_of((c.x + c.y + c.z) / 3);
}

// UsdPreviewSurface ---------------------------------------------------------------------------------------------

// Inputs: of the metal workflow, useSpecularWorkflow, maybe what the other takes.
Signal of_metal_workflow(const Terms& in) {
  if (!is_on(in.number(1))) return in[0];
  return signal_of(in.factor());
}

// F0 itself. AlabasterDisney's specularColor scales that of its ior, which is then 1.5.
Signal of_specular_workflow(const Terms& in) {
  if (!is_on(in.number(1))) return signal_of(1.0f);
  return affine(in[0], Vec4f(kSpecularColorOfOne), Vec4f(0)).value();
}

// Inputs: opacity, its threshold and its mode, of which transparent is the default. Returns 1 for that.
Signal preview_opacity_mode(const Terms& in) {
  const bool thresholded = in[1].is_used(), presence = in.word(2) == "presence" || is_on(in.number(2));
  const bool partly = in[0].is_textured() || in[0].constant.x < 1;
  return signal_of(partly && !thresholded && !presence ? 1.0f : 0.0f);
}

// What a coat does to the parameters below it -------------------------------------------------------------------

void tell_coat(const Terms& in) {
  in.tell("a coat does not change the roughness, ior and emission below it where some of these have textures");
}

/// `asked` below a coat of the weight in[weight] is `coated(asked)` by that share.
template <class F>
Signal below_coat(const Terms& in, size_t weight, const Signal& asked, bool is_alone, const F& coated) {
  if (!in[weight].is_used()) return asked;
  if (!is_alone || asked.is_textured() || in[weight].is_textured()) return tell_coat(in), asked;
  const float c = std::min(in.number(weight), 1.0f), bare = asked.constant.x;
  return signal_of(bare + (coated(bare) - bare) * c);
}

// Inputs: luminance, colour, coat, its colour.
Signal coated_emission(const Terms& in) {
  const Signal emission = product(in[0], in[1]).value_or(in[1]);
  const bool is_clear = !in[3].is_textured() && in[3].rgb() == Vec3f(1);
  if (!emission.is_used() || !in[2].is_used() || is_clear) return emission;
  std::optional<Signal> passed;
  if (!in[2].is_textured()) passed = mixture(signal_of(1.0f), in[3], Vec4f(std::min(in.number(2), 1.0f)));
  if (passed) passed = product(emission, *passed);
  if (!passed) tell_coat(in);
  return passed.value_or(emission);
}

// OpenPBR -------------------------------------------------------------------------------------------------------

// Along the tangent alpha is roughness^2 (2 / (1 + (1 - a)^2))^.5, across 1 - a of it; ours have the product
// roughness^4. Below a coat of roughness r_c it is (r^4 + 2 r_c^4)^.25 at most 1 (OpenPBR 1.1.1, "Coat", "Roughening").
Signal open_pbr_roughness(const Terms& in) {
  const float across = 1 - std::min(in.number(1), 0.999f);
  const float scale = std::pow(2 * across / (1 + across * across), 0.25f);
  Signal roughness = in[0];
  if (in[3].is_used())
    roughness = below_coat(in, 2, in[0], !in[3].is_textured(), [&](float r) {
      const float c = in.number(3);
      return std::pow(std::min(r * r * r * r + 2 * c * c * c * c, 1.0f), 0.25f);
    });
  return affine(roughness, Vec4f(scale), Vec4f(0)).value();
}

// Inputs: ior, coat, its ior, transmission. Below a coat that of the base over the coat's, the greater by the lesser
// ("Coat", "Total internal reflection").
Signal open_pbr_ior(const Terms& in) {
  if (in[3].is_used()) return in[0];
  return below_coat(in, 1, in[0], !in[2].is_textured(), [&](float i) {
    const float n = std::max(in.number(2), 1.0f);
    return std::max(i / n, n / i);
  });
}

// disney_principled ---------------------------------------------------------------------------------------------

// Without specTrans F0 is .08 specular.
Signal principled_ior(const Terms& in) {
  if (in[1].is_used()) return signal_of(in.number(2));
  const float f = std::sqrt(0.08f * std::clamp(in.number(0), 0.0f, 1.0f));
  return signal_of((1 + f) / (1 - f));
}

// glTF ----------------------------------------------------------------------------------------------------------

// alpha_t = mix(alpha, 1, strength^2), alpha_b = alpha = roughness^2; ours have the ratio 1 - 0.9 anisotropic and the
// product roughness^4. Returns alpha_b and alpha_t.
std::pair<float, float> gltf_alphas(const Terms& in, size_t roughness, size_t strength) {
  const float r = in.number(roughness), s = in.number(strength);
  const float b = std::max(r * r, float(kMinAlpha));
  return {b, b + (1 - b) * s * s};
}

Signal gltf_roughness(const Terms& in) {
  if (!in[1].is_used()) return in[0];
  const auto [b, t] = gltf_alphas(in, 0, 1);
  return signal_of(std::pow(t * b, 0.25f));
}

Signal gltf_anisotropic(const Terms& in) {
  if (!in[1].is_used()) return signal_of(0.0f);
  const auto [b, t] = gltf_alphas(in, 0, 1);
  return signal_of((1 - std::max(b / t, 1.1e-3f)) / 0.9f);
}

// ior 0 reflects everything: f0 is the specular colour itself.
Signal gltf_ior(const Terms& in) {
  const float ior = in.number(0);
  if (ior > 0 && ior < 1) in.tell("ior below 1 is not supported; 1.5 is used");
  return signal_of(ior < 1 ? 1.5f : ior);
}
Signal gltf_specular_color(const Terms& in) {
  return affine(in[0], Vec4f(in.number(1) == 0 ? kSpecularColorOfOne : 1), Vec4f(0)).value();
}

// Inputs: alpha, alpha_mode (0 opaque, 1 mask, 2 blend), alpha_cutoff.
Signal gltf_opacity(const Terms& in) {
  const float mode = in.number(1), cutoff = in.number(2);
  if (mode == 0 || (mode == 1 && cutoff <= 0)) return signal_of(1.0f);
  return mode == 1 && cutoff > 1 ? signal_of(0.0f) : in[0];
}
Signal gltf_threshold(const Terms& in) {
  const float cutoff = in.number(2);
  return signal_of(in.number(1) == 1 && cutoff <= 1 ? std::max(cutoff, 0.0f) : 0);
}

/// The volume of a glTF material: what rows about it have as their first inputs.
std::vector<LookInput> with_volume(std::vector<LookInput> before, const std::vector<LookInput>& after = {}) {
  const std::vector<LookInput> volume{{"thickness"},        {"attenuation_color", Vec3f(1)}, {"attenuation_distance"},
                                      {"scatter_strength"}, {"multiscatter_color", 1},       {"transmission"}};
  before.insert(before.end(), volume.begin(), volume.end());
  before.insert(before.end(), after.begin(), after.end());
  return before;
}
struct Volume {
  Volume(const Terms& in, size_t first)
      : is_there(in[first].is_used()),
        color(in.color(first + 1)),
        distance(in.number(first + 2)),
        strength(in.number(first + 3)),
        transmission(in[first + 5]) {}
  bool attenuates() const { return is_there && distance > 0 && color != Vec3f(1); }
  bool scatters() const { return attenuates() && strength > 0; }

  bool is_there;
  Vec3f color;
  float distance, strength;
  const Signal& transmission;
};

// A clear solid takes the square root of its colour at each surface (Burley 2015), the extension the colour itself.
Signal gltf_base_color(const Terms& in) {
  const Volume volume(in, 1);
  if (!volume.is_there || !volume.transmission.is_used()) return in[0];
  const Signal tint = product(in[0], in[0]).value_or(in[0]);
  if (!volume.transmission.is_textured() && volume.transmission.constant.x >= 1) return tint;
  if (tint != in[0]) in.tell("a partly clear solid has the colour of its base for the light through it, too");
  return in[0];
}

Signal gltf_mean_free_path(const Terms& in) {
  const Volume volume(in, 0);
  Vec3f path(0);
  for (int c = 0; volume.scatters() && c < 3; ++c)
    path[c] = float(attenuation_path(double(volume.color[c]), double(volume.distance)));
  return signal_of(path);
}

// A volume without scattering leaves the surface its own colour.
Signal gltf_medium_color(const Terms& in) {
  const Volume volume(in, 0);
  if (volume.is_there && !volume.scatters()) return signal_of(DisneyParameters().subsurface_color.r);
  return affine(in[4], Vec4f(volume.is_there ? volume.strength : 1), Vec4f(0)).value();
}

Signal gltf_attenuation_distance(const Terms& in) {
  const Volume volume(in, 0);
  return signal_of(volume.attenuates() && !volume.scatters() ? volume.distance : 0);
}

// A surface without a volume is a sheet.
Signal gltf_thin(const Terms& in) {
  const Volume volume(in, 0);
  return signal_of(!volume.is_there && (volume.transmission.is_used() || in[6].is_used()) ? 1.0f : 0.0f);
}

// Into a scattering volume it is the walk.
Signal gltf_diffuse(const Terms& in) {
  return affine(in[6], Vec4f(Volume(in, 0).scatters() ? 0 : 2), Vec4f(0)).value();
}

// KHR_materials_scatter on a sheet: transmission x mix(clear sheet, scatter, strength).
Signal gltf_clear_share(const Terms& in) {
  const Volume volume(in, 0);
  const float clear = volume.is_there ? 1 : 1 - volume.strength;
  return affine(volume.transmission, Vec4f(clear), Vec4f(0)).value();
}
Signal gltf_sheet_share(const Terms& in) {
  const Volume volume(in, 0);
  if (volume.is_there) return signal_of(1.0f);
  const float t = in.number(5), rest = 1 - t * (1 - volume.strength);
  return signal_of(rest > 0 ? t * volume.strength / rest : 0);
}

// clang-format would give each element a line.
// clang-format off
Look standard_surface(const char* type, float base, float base_color) {
  const char *const below = "subsurface", *const clear = "transmission", *const film = "thin_film_thickness";
  return {{type}, {
      {"baseColor", {{"base", base}, {"base_color", base_color}}},
      {"metallic", {"metalness"}},
      {"roughness", {{"specular_roughness", 0.2f}}},
      {"diffuseRoughness", {}, nullptr, product_of, kLambertRoughness},
      {"ior", {{"specular_IOR", 1.5f}}},
      {"specular", {{"specular", 1}}},
      {"specularColor", {{"specular_color", 1}}},
      {"anisotropic", {"specular_anisotropy"}, nullptr, product_of, 1 / 0.9f},
      {"anisotropicRotation", {"specular_rotation"}, "specular_anisotropy"},
      {"subsurfaceWeight", {"subsurface"}, below},
      {"subsurfaceColor", {{"subsurface_color", 1}}, below},
      {"meanFreePath", {{"subsurface_radius", 1}, {"subsurface_scale", 1}}, below},
      {"scatterAnisotropy", {"subsurface_anisotropy"}, below},
      {"thin", {"thin_walled"}},
      {"specTrans", {"transmission"}},
      {"transmissionColor", {{"transmission_color", 1}}, clear},
      {"transmissionDepth", {"transmission_depth"}, clear},
      {"transmissionScatter", {"transmission_scatter"}, clear},
      {"transmissionAnisotropy", {"transmission_scatter_anisotropy"}, clear},
      {"dispersion", {"transmission_dispersion"}, clear, inverse, 20},
      {"coat", {"coat"}},
      {"coatRoughness", {{"coat_roughness", 0.1f}}, "coat"},
      {"coatIor", {{"coat_IOR", 1.5f}}, "coat"},
      {"coatColor", {{"coat_color", 1}}, "coat"},
      {"sheen", {"sheen"}},
      {"sheenTint", {}, "sheen", product_of, 0},
      {"sheenColor", {{"sheen_color", 1}}, "sheen"},
      {"sheenRoughness", {{"sheen_roughness", 0.3f}}, "sheen", sheen_roughness},
      {"iridescence", {"thin_film_thickness"}, nullptr, is_positive},
      {"iridescenceThickness", {"thin_film_thickness"}, film},
      {"iridescenceIor", {{"thin_film_IOR", 1.5f}}, film},
      {"emission", {"emission", {"emission_color", 1}, "coat", {"coat_color", 1}}, nullptr, coated_emission},
      {"opacity", {{"opacity", 1}}, nullptr, mean},
      {"normal", {"normal"}, nullptr, normals_of},
      {"coatNormal", {"coat_normal"}, "coat", normals_of},
  }, {
      {{"specular_color", 1}, 1, "metalness"},
      {"diffuse_roughness"},
      {"transmission_extra_roughness", 0, clear},
      {"coat_anisotropy", 0, "coat"},
      {"coat_rotation", 0, "coat_anisotropy"},
      {"coat_affect_color", 0, "coat"},
      {"coat_affect_roughness", 0, "coat"},
      {"tangent"},
  }};
}

Look open_pbr(const char* type) {
  const char *const below = "subsurface_weight", *const clear = "transmission_weight", *const coat = "coat_weight";
  const char *const fuzz = "fuzz_weight", *const film = "thin_film_weight";
  return {{type}, {
      {"baseColor", {{"base_weight", 1}, {"base_color", 0.8f}}},
      {"metallic", {"base_metalness"}},
      {"roughness", {{"specular_roughness", 0.3f}, "specular_roughness_anisotropy", coat, "coat_roughness"}, nullptr, open_pbr_roughness},
      {"diffuseRoughness", {}, nullptr, product_of, kLambertRoughness},
      {"ior", {{"specular_ior", 1.5f}, coat, {"coat_ior", 1.6f}, clear}, nullptr, open_pbr_ior},
      {"specular", {{"specular_weight", 1}}},
      {"specularColor", {{"specular_color", 1}}},
      {"anisotropic", {"specular_roughness_anisotropy"}, nullptr, product_of, 1 / 0.9f},
      {"subsurfaceWeight", {"subsurface_weight"}, below},
      {"subsurfaceColor", {{"subsurface_color", 0.8f}}, below},
      {"meanFreePath", {{"subsurface_radius", 1}, {"subsurface_radius_scale", Vec3f(1, 0.5f, 0.25f)}}, below},
      {"scatterAnisotropy", {"subsurface_scatter_anisotropy"}, below},
      {"thin", {"geometry_thin_walled"}},
      {"specTrans", {"transmission_weight"}},
      {"transmissionColor", {{"transmission_color", 1}}, clear},
      {"transmissionDepth", {"transmission_depth"}, clear},
      {"transmissionScatter", {"transmission_scatter"}, clear},
      {"transmissionAnisotropy", {"transmission_scatter_anisotropy"}, clear},
      {"dispersion", {"transmission_dispersion_scale", {"transmission_dispersion_abbe_number", 20}}, clear, quotient, 20},
      {"coat", {"coat_weight"}},
      {"coatRoughness", {"coat_roughness"}, coat},
      {"coatIor", {{"coat_ior", 1.6f}}, coat},
      {"coatColor", {{"coat_color", 1}}, coat},
      {"coatDarkening", {{"coat_darkening", 1}}, coat},
      {"sheen", {"fuzz_weight"}},
      {"sheenTint", {}, fuzz, product_of, 0},
      {"sheenColor", {{"fuzz_color", 1}}, fuzz},
      {"sheenRoughness", {{"fuzz_roughness", 0.5f}}, fuzz, sheen_roughness},
      {"iridescence", {"thin_film_weight"}},
      {"iridescenceThickness", {{"thin_film_thickness", 0.5f}}, film, product_of, 1000},
      {"iridescenceIor", {{"thin_film_ior", 1.4f}}, film},
      {"emission", {"emission_luminance", {"emission_color", 1}, coat, {"coat_color", 1}}, nullptr, coated_emission},
      {"opacity", {{"geometry_opacity", 1}}},
      {"normal", {"geometry_normal"}, nullptr, normals_of},
      {"coatNormal", {"geometry_coat_normal"}, coat, normals_of},
  }, {
      {{"specular_color", 1}, 1, "base_metalness"},
      {"base_diffuse_roughness"},
      {"coat_roughness_anisotropy", 0, coat},
      {"geometry_tangent"},
      {"geometry_coat_tangent", 0, coat},
  }};
}

Look preview_surface() {
  return {{"UsdPreviewSurface", "ND_UsdPreviewSurface_surfaceshader"}, {
      {"baseColor", {{"diffuseColor", 0.18f}}},
      {"emission", {"emissiveColor"}},
      {"metallic", {"metallic", "useSpecularWorkflow"}, nullptr, of_metal_workflow, 0},
      {"ior", {{"ior", 1.5f}, "useSpecularWorkflow"}, nullptr, of_metal_workflow, 1.5f},
      {"specularColor", {"specularColor", "useSpecularWorkflow"}, nullptr, of_specular_workflow},
      {"roughness", {{"roughness", 0.5f}}},
      {"diffuseRoughness", {}, nullptr, product_of, kLambertRoughness},
      {"coat", {"clearcoat"}},
      {"coatRoughness", {{"clearcoatRoughness", 0.01f}}},
      {"opacity", {{"opacity", 1}}},
      {"opacityMode", {{"opacity", 1}, "opacityThreshold", {"opacityMode", 0, true}}, nullptr, preview_opacity_mode},
      {"opacityThreshold", {"opacityThreshold"}},
      {"normal", {"normal"}, nullptr, normals_of},
  }, {}, {"occlusion", "displacement"}};
}

Look disney_principled() {
  const LookInput color{"baseColor", 0.16f};
  return {{"ND_disney_principled"}, {
      {"baseColor", {color}},
      {"metallic", {"metallic"}},
      {"roughness", {{"roughness", 0.5f}}},
      {"anisotropic", {"anisotropic"}},
      {"ior", {{"specular", 0.5f}, "specTrans", {"ior", 1.5f}}, nullptr, principled_ior},
      {"specularTint", {"specularTint"}},
      {"sheen", {"sheen"}},
      {"sheenTint", {{"sheenTint", 0.5f}}},
      {"clearcoat", {"clearcoat"}},
      {"clearcoatGloss", {{"clearcoatGloss", 1}}},
      {"specTrans", {"specTrans"}},
      {"transmissionColor", {color}, "specTrans"},
      {"subsurfaceWeight", {"subsurface"}, "subsurface"},
      {"subsurfaceColor", {color}, "subsurface"},
      {"meanFreePath", {{"subsurfaceDistance", 1}}, "subsurface"},
  }, {}};
}

// With KHR_materials_scatter and KHR_materials_diffuse_transmission in MaterialX's spelling.
Look gltf_pbr() {
  const char *const film = "iridescence", *const sheen = "sheen_color", *const cloud = "scatter_strength";
  return {{"ND_gltf_pbr_surfaceshader"}, {
      {"baseColor", with_volume({{"base_color", 1}}), nullptr, gltf_base_color},
      {"metallic", {{"metallic", 1}}},
      {"roughness", {{"roughness", 1}, "anisotropy_strength"}, nullptr, gltf_roughness},
      {"anisotropic", {{"roughness", 1}, "anisotropy_strength"}, nullptr, gltf_anisotropic},
      {"anisotropicRotation", {"anisotropy_rotation"}, "anisotropy_strength", product_of, 0.5f * std::numbers::inv_pi_v<float>},
      {"ior", {{"ior", 1.5f}}, nullptr, gltf_ior},
      {"specular", {{"specular", 1}}},
      {"specularColor", {{"specular_color", 1}, {"ior", 1.5f}}, nullptr, gltf_specular_color},
      {"thin", with_volume({}, {"diffuse_transmission"}), nullptr, gltf_thin},
      {"specTrans", with_volume({}), "transmission", gltf_clear_share},
      {"subsurfaceWeight", with_volume({}), cloud, gltf_sheet_share},
      {"subsurfaceColor", with_volume({}), cloud, gltf_medium_color},
      {"meanFreePath", with_volume({}), cloud, gltf_mean_free_path},
      {"scatterAnisotropy", {"scatter_anisotropy"}, cloud},
      {"diffTrans", with_volume({}, {"diffuse_transmission"}), "diffuse_transmission", gltf_diffuse},
      {"diffTransColor", {{"diffuse_transmission_color", 1}}, "diffuse_transmission"},
      {"attenuationColor", {{"attenuation_color", 1}}, "thickness"},
      {"attenuationDistance", with_volume({}), "thickness", gltf_attenuation_distance},
      {"dispersion", {"dispersion"}, "thickness"},
      {"coat", {"clearcoat"}},
      {"coatRoughness", {"clearcoat_roughness"}, "clearcoat"},
      {"sheen", {"sheen_color"}, nullptr, is_positive},
      {"sheenTint", {}, sheen, product_of, 0},
      {"sheenColor", {"sheen_color"}, sheen},
      {"sheenRoughness", {"sheen_roughness"}, sheen, sheen_roughness},
      {"iridescence", {"iridescence"}},
      {"iridescenceThickness", {{"iridescence_thickness", 100}}, film},
      {"iridescenceIor", {{"iridescence_ior", 1.3f}}, film},
      {"emission", {"emissive", {"emissive_strength", 1}}},
      {"opacity", {{"alpha", 1}, "alpha_mode", {"alpha_cutoff", 0.5f}}, nullptr, gltf_opacity},
      {"opacityThreshold", {{"alpha", 1}, "alpha_mode", {"alpha_cutoff", 0.5f}}, nullptr, gltf_threshold},
      {"normal", {"normal"}, nullptr, normals_of},
      {"coatNormal", {"clearcoat_normal"}, "clearcoat", normals_of},
  }, {{"tangent"}}, {"occlusion"}};
}
// clang-format on

Look of_arnold(const char* type, Look look) {
  look.types = {type}, look.has_others = true;
  return look;
}

}  // namespace

const std::vector<Look>& look_tables() {
  static const std::vector<Look> kTables{preview_surface(),
                                         standard_surface("ND_standard_surface_surfaceshader", 1, 0.8f),
                                         standard_surface("ND_standard_surface_surfaceshader_100", 0.8f, 1),
                                         of_arnold("arnold:standard_surface", standard_surface("", 1, 0.8f)),
                                         open_pbr("ND_open_pbr_surface_surfaceshader"),
                                         of_arnold("arnold:openpbr_surface", open_pbr("")),
                                         disney_principled(),
                                         gltf_pbr()};
  return kTables;
}

}  // namespace alabaster::hd::looks
