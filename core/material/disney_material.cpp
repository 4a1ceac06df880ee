#include "core/material/disney_material.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/material/scatter_distance.h"

namespace alabaster {
namespace {

using P = DisneyParameters;

// The second line of a row is its unit and its description. clang-format would give each element a line.
// clang-format off
constexpr auto kParameters = std::to_array<MaterialParameter>({
    {{"baseColor", &P::base_color, 0, 1, {},
      "none", "Surface colour: the diffuse albedo, the colour of metals, and without subsurfaceColor the "
      "multiple-scattering albedo of subsurface scattering."}, Texels::colors},
    {{"metallic", &P::metallic, 0, 1, {},
      "none", "0 is a dielectric, 1 a metal of colour baseColor."}},
    {{"roughness", &P::roughness, 0, 1, {},
      "none", "Perceived roughness of the specular lobe, and without diffuseRoughness of the diffuse "
      "retro-reflection."}},
    {{"diffuseRoughness", &P::diffuse_roughness, -1, 1, {},
      "none", "Roughness of the diffuse retro-reflection; 0.43 is Lambert's law within 1 % up to 78 degrees. Below 0 it "
      "is roughness."}},
    {{"anisotropic", &P::anisotropic, 0, 1.11, {},
      "none", "Stretch of the specular highlight along the tangent: its two alphas have the ratio 1 - 0.9 "
      "anisotropic, 0.1 at 1, where Disney's range ends, and 0.001 at 1.11."}},
    {{"anisotropicRotation", &P::anisotropic_rotation, -kUnbounded, kUnbounded, {},
      "turns", "Turns the direction of the stretch about the normal, from where u grows towards where v grows: 0.25 "
      "is across, and 1.25 is the same."}},
    {{"specularTint", &P::specular_tint, 0, 1, {},
      "none", "Tints the dielectric specular reflection towards the hue of baseColor."}},
    {{"ior", &P::ior, 1, 4, {},
      "none", "Index of refraction of the dielectric specular lobe."}},
    {{"specular", &P::specular, 0, 1, {},
      "none", "Scales the dielectric reflectance at normal incidence; 1 leaves it to ior alone."}},
    {{"specularColor", &P::specular_color, 0, kUnbounded, {},
      "none", "Tints the dielectric reflectance at normal incidence."}, Texels::colors},
    {{"sheen", &P::sheen, 0, 1, {},
      "none", "Strength of the grazing-angle lobe of cloth."}},
    {{"sheenTint", &P::sheen_tint, 0, 1, {},
      "none", "Tints the sheen towards the hue of baseColor."}},
    {{"sheenColor", &P::sheen_color, 0, 1, {},
      "none", "Colour of the sheen, beside the tint."}, Texels::colors},
    {{"sheenRoughness", &P::sheen_roughness, 0, 1, {},
      "none", "Above 0 the sheen is that of fibres with this roughness, a layer that takes what it reflects from the "
      "surface below. 0: Disney's sheen, which is a tenth as strong."}},
    {{"clearcoat", &P::clearcoat, 0, 1, {},
      "none", "Strength of a second, thin and colourless specular layer."}},
    {{"clearcoatGloss", &P::clearcoat_gloss, 0, 1, {},
      "none", "Gloss of the clearcoat, from 0 (satin) to 1 (glossy)."}},
    {{"coat", &P::coat, 0, 1, {},
      "none", "Weight of a clear layer of index coatIor over the whole surface, which takes what it reflects from what "
      "lies below. Above 0 it replaces clearcoat, which is a quarter as strong."}},
    {{"coatRoughness", &P::coat_roughness, 0, 1, {},
      "none", "Perceived roughness of the coat."}},
    {{"coatIor", &P::coat_ior, 1, 4, {},
      "none", "Index of refraction of the coat; at 1 it reflects nothing."}},
    {{"coatColor", &P::coat_color, 0, 1, {},
      "none", "Colour that white light has once it has passed the coat twice, in and out."}, Texels::colors},
    {{"coatDarkening", &P::coat_darkening, 0, 1, {},
      "none", "Share of the darkening and saturation of what lies below a coat by light that the coat sends back to it "
      "again and again. 0: none."}},
    {{"scatterDistance", &P::scatter_distance, 0, kUnbounded, {},
      "scene unit", "Mean distance that light travels below the surface, per channel; in a scene in metres, as "
      "glTF is, 0.001 is one millimetre. 0 in all channels gives an opaque diffuse surface."}},
    {{"scatterAnisotropy", &P::scatter_anisotropy, -0.9, 0.9, {},
      "none", "Mean cosine of scattering below the surface (Henyey-Greenstein g): backward below 0, forward above 0. "
      "Colour and scatterDistance keep their meaning."}},
    {{"meanFreePath", &P::mean_free_path, 0, kUnbounded, {},
      "scene unit", "Mean free path below the surface, per channel: the mean way between two events of scattering, "
      "whatever the colour and scatterAnisotropy. Above 0 it takes the place of scatterDistance."}},
    {{"subsurfaceWeight", &P::subsurface_weight, 0, 1, {},
      "none", "Share of the diffuse light that goes below the surface; the rest is reflected by baseColor. Light that "
      "enters where it is lower or higher than where it leaves counts by the lower of the two, and where it is 0 the "
      "surface is opaque from inside, too. Not of thin surfaces."}},
    {{"subsurfaceColor", &P::subsurface_color, -1, 1, {},
      "none", "Multiple-scattering albedo of subsurface scattering, and the colour of the share subsurfaceWeight where "
      "a channel has no distance. Below 0 it is baseColor, with its textures."}, Texels::colors},
    {{"emission", &P::emission, 0, kUnbounded, {},
      "radiance", "Radiance that the surface emits on both sides."}, Texels::colors},
    {{"opacity", &P::opacity, 0, 1, {},
      "none", "Share of the surface that is there; rays pass the rest as if there were nothing. Behind the wall of a "
      "closed body these rays are in air, and meet the far wall from inside: it reflects as with scatterDistance 0, "
      "and its clear share is that of a thin sheet. Two walls of opacity 0.5 so have alpha 0.75. Light below the "
      "surface and within a clear body ignores opacity."}},
    {{"opacityThreshold", &P::opacity_threshold, 0, 1, {},
      "none", "Above 0 the surface is cut out: it is there where opacity reaches the threshold, and nowhere else."}},
    {{"opacityMode", &P::opacity_mode, -kUnbounded, kUnbounded, {"presence", "transparent"},
      "none", "transparent: the surface is a sheet, as with thin, and opacity the share of it that is not clear: light "
      "passes the rest straight on and untinted, below the full highlight, coat and fibres; no light walks below. With "
      "opacityThreshold it is cut out all the same. A metal keeps its reflection."}},
    {{"sides", &P::sides, -kUnbounded, kUnbounded, {"mesh", "front", "both"},
      "none", "Sides of the surface that exist. front: back faces are culled for rays of the camera, of shadows and of "
      "light, and do not emit. mesh: as the mesh's doubleSided. A material that lets light below the surface has "
      "both."}},
    {{"specTrans", &P::spec_trans, 0, 1, {},
      "none", "Share of the dielectric base that is clear: light is reflected and refracted by ior and roughness, "
      "and takes the square root of baseColor at each of the two surfaces that it passes, but in a body that scatters "
      "without subsurfaceColor, whose medium has that colour."}},
    {{"thin", &P::thin, -kUnbounded, kUnbounded, {},
      "none", "The surface is a sheet without an interior: light passes without refraction, takes baseColor once, "
      "and is spread by roughness (0.65 ior - 0.35). It has two faces, which reflect as those of a slab do."}},
    {{"flatness", &P::flatness, 0, 1, {},
      "none", "Blends the diffuse reflection of a thin surface towards the flatter one of a medium below it."}},
    {{"diffTrans", &P::diff_trans, 0, 2, {},
      "none", "Diffuse light that leaves on the other side: 1 for half of it, 2 for all."}},
    {{"diffTransColor", &P::diff_trans_color, 0, 1, {},
      "none", "Colour of the diffuse light that leaves on the other side."}, Texels::colors},
    {{"attenuationColor", &P::attenuation_color, 0, 1, {},
      "none", "Colour of white light after attenuationDistance inside a clear body. Where scatterDistance is given, "
      "that rules the interior instead."}, Texels::colors},
    {{"attenuationDistance", &P::attenuation_distance, 0, kUnbounded, {},
      "scene unit", "Distance after which light inside a clear body has taken attenuationColor; 0: it is not "
      "absorbed."}},
    {{"priority", &P::priority, 0, 255, {},
      "none", "Where clear bodies overlap, the one of the highest priority is there and the surfaces of the others "
      "inside it are not; among equals the smaller one. A body in which light scatters (scatterDistance) comes "
      "before clear ones of any priority, but for those of no lower priority that lie inside it as a whole."}},
    {{"dispersion", &P::dispersion, 0, 20, {},
      "none", "Spread of ior over the channels, 20 over the Abbe number (KHR_materials_dispersion): ior is green's. "
      "Only of a clear body. Each path that meets one keeps one channel, which costs noise."}},
    {{"iridescence", &P::iridescence, 0, 1, {},
      "none", "Share of the surface under a thin film whose interference colours the specular reflection."}},
    {{"iridescenceIor", &P::iridescence_ior, 1, 4, {},
      "none", "Index of refraction of the thin film."}},
    {{"iridescenceThickness", &P::iridescence_thickness, 0, kUnbounded, {},
      "nanometre", "Thickness of the thin film."}},
});
// clang-format on

// The value in the row's range; the default where it is not finite.
float clamped(float value, const MaterialParameter& row, float fallback) {
  constexpr double kLargest = std::numeric_limits<float>::max();
  const auto low = static_cast<float>(row.minimum), high = static_cast<float>(std::min(row.maximum, kLargest));
  return std::isfinite(value) ? std::clamp(value, low, high) : fallback;
}

void clamp_member(const MaterialParameter& row, DisneyParameters* p) {
  static const DisneyParameters kDefaults;
  if (const auto* color = std::get_if<Rgb P::*>(&row.member)) {
    for (int i = 0; i < 3; ++i) (p->**color)[i] = clamped((p->**color)[i], row, (kDefaults.**color)[i]);
  } else if (const auto* number = std::get_if<float P::*>(&row.member)) {
    p->** number = clamped(p->**number, row, kDefaults.**number);
  }
}

float channel_of(const Rgb& color, Channel channel) {
  return color[component_of(channel)];
}

void multiply(const MaterialTexture& texture, const HitPrimvars& at, DisneyParameters* p) {
  std::optional<Rgb> color;
  std::optional<float> alpha;
  for (const auto& [row, channel] : texture.uses) {
    if (channel == Channel::direction) [[unlikely]] {
      if (const auto* number = std::get_if<float P::*>(&row->member)) p->** number *= texture.lookup.direction(at);
      continue;
    }
    if (channel == Channel::a && !alpha) alpha = texture.lookup.alpha(at);
    if (channel != Channel::a && !color) color = texture.lookup.color(at);
    const auto* const member = std::get_if<Rgb P::*>(&row->member);
    if (member && channel == Channel::rgb)
      p->** member *= *color;
    else if (const float factor = channel == Channel::a ? *alpha : channel_of(*color, channel); member)
      p->** member *= factor;
    else
      p->*std::get<float P::*>(row->member) *= factor;
  }
}

template <class Member>
bool any_use(const std::vector<MaterialTexture>& textures, Member member) {
  for (const MaterialTexture& texture : textures)
    for (const MaterialTexture::Use& use : texture.uses)
      if (use.parameter->member == decltype(use.parameter->member)(member)) return true;
  return false;
}

}  // namespace

void DisneyMaterial::evaluate(const HitPrimvars& at, DisneyParameters* p) const {
  *p = constants;
  if (!textures.empty()) {
    for (const MaterialTexture& texture : textures) multiply(texture, at, p);
    // After all of them: the product counts, not its steps.
    for (const MaterialTexture& texture : textures)
      for (const MaterialTexture::Use& use : texture.uses) clamp_member(*use.parameter, p);
  }
  if (max_component(p->mean_free_path) > 0) [[unlikely]]
    p->take_mean_free_path();
  if (p->is_transparent()) [[unlikely]]
    p->spec_trans = 1 - p->opacity;
}

void DisneyMaterial::settle_opacity_mode() {
  DisneyParameters& p = constants;
  if (p.opacity_threshold > 0) p.opacity_mode = OpacityMode::presence;
  if (!p.is_transparent()) return;
  p.thin = true;
  p.spec_trans = p.opacity < 1 || varies(&P::opacity) ? 1.0f : 0.0f;  // clear somewhere
}

void DisneyParameters::take_mean_free_path() {
  const Rgb albedo = medium_albedo();
  for (int c = 0; c < 3; ++c)
    if (mean_free_path[c] > 0)
      scatter_distance[c] = static_cast<float>(double(mean_free_path[c]) /
                                               ((1 - double(scatter_anisotropy)) * distance_scale(double(albedo[c]))));
}

void convert_color(const MaterialParameter& row, const RgbMatrix& matrix, DisneyParameters* p) {
  Rgb& color = p->*std::get<Rgb P::*>(row.member);
  color = matrix(color);
  clamp_member(row, p);
}

bool DisneyMaterial::varies(Rgb DisneyParameters::*parameter) const {
  return any_use(textures, parameter);
}
bool DisneyMaterial::varies(float DisneyParameters::*parameter) const {
  return any_use(textures, parameter);
}

bool DisneyMaterial::is_partly_closed() const {
  const bool all_clear = constants.spec_trans == 1 && !varies(&P::spec_trans);
  return scatters() && !all_clear && (constants.subsurface_weight == 0 || varies(&P::subsurface_weight));
}

bool DisneyMaterial::varies_albedo() const {
  return varies(constants.has_own_albedo() ? &P::subsurface_color : &P::base_color);
}

bool DisneyMaterial::is_partly_opaque() const {
  return !constants.is_transparent() && (constants.opacity < 1 || varies(&P::opacity));
}

float DisneyMaterial::coverage(const HitPrimvars& at) const {
  if (constants.is_transparent()) return 1;
  const auto value = [&](float DisneyParameters::*member) {
    float product = constants.*member;
    for (const MaterialTexture& texture : textures)
      for (const auto& [row, channel] : texture.uses)
        if (row->member == decltype(row->member)(member))
          product *= channel == Channel::a ? texture.lookup.alpha(at) : channel_of(texture.lookup.color(at), channel);
    return std::isfinite(product) ? std::clamp(product, 0.0f, 1.0f) : DisneyParameters().*member;
  };
  const float opacity = value(&P::opacity), threshold = value(&P::opacity_threshold);
  return threshold > 0 ? (opacity >= threshold ? 1.0f : 0.0f) : opacity;
}

template <class Visit>
static void for_each_lookup(const DisneyMaterial& material, const Visit& visit) {
  for (const MaterialTexture& texture : material.textures) visit(texture.lookup);
  for (const auto* map : {&material.normal_map, &material.coat_normal_map})
    if (*map) visit(**map);
  if (material.displacement) visit(material.displacement->texture);
}

std::vector<const Texture*> DisneyMaterial::images() const {
  std::vector<const Texture*> all;
  for_each_lookup(*this, [&](const TextureLookup& one) {
    if (one.image) all.push_back(one.image.get());
  });
  return all;
}

std::vector<UvSetName> DisneyMaterial::primvars() const {
  std::vector<UvSetName> all;
  for_each_lookup(*this, [&](const TextureLookup& one) {
    if (!one.image) all.push_back(one.primvar);
  });
  return all;
}

bool DisneyMaterial::reads(const UvSetName& primvar) const {
  bool found = false;
  for_each_lookup(*this, [&](const TextureLookup& one) { found = found || one.primvar == primvar; });
  return found;
}

std::span<const MaterialParameter> material_parameters() {
  return kParameters;
}

const MaterialParameter* find_material_parameter(std::string_view name) {
  const auto found =
      std::find_if(kParameters.begin(), kParameters.end(), [&](const auto& row) { return name == row.name; });
  return found == kParameters.end() ? nullptr : &*found;
}

}  // namespace alabaster
