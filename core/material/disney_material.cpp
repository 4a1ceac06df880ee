#include "core/material/disney_material.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace alabaster {
namespace {

using P = DisneyParameters;

constexpr auto kParameters = std::to_array<MaterialParameter>({
    {{"baseColor", &P::base_color, 0, 1}, Texels::colors},
    {{"metallic", &P::metallic, 0, 1}},
    {{"roughness", &P::roughness, 0, 1}},
    {{"anisotropic", &P::anisotropic, 0, 1.11}},
    {{"anisotropicRotation", &P::anisotropic_rotation}},
    {{"specularTint", &P::specular_tint, 0, 1}},
    {{"ior", &P::ior, 1, 4}},
    {{"specular", &P::specular, 0, 1}},
    {{"specularColor", &P::specular_color, 0, kUnbounded}, Texels::colors},
    {{"sheen", &P::sheen, 0, 1}},
    {{"sheenTint", &P::sheen_tint, 0, 1}},
    {{"sheenColor", &P::sheen_color, 0, 1}, Texels::colors},
    {{"sheenRoughness", &P::sheen_roughness, 0, 1}},
    {{"clearcoat", &P::clearcoat, 0, 1}},
    {{"clearcoatGloss", &P::clearcoat_gloss, 0, 1}},
    {{"coat", &P::coat, 0, 1}},
    {{"coatRoughness", &P::coat_roughness, 0, 1}},
    {{"scatterDistance", &P::scatter_distance, 0, kUnbounded}},
    {{"scatterAnisotropy", &P::scatter_anisotropy, -0.9, 0.9}},
    {{"emission", &P::emission, 0, kUnbounded}, Texels::colors},
    {{"opacity", &P::opacity, 0, 1}},
    {{"opacityThreshold", &P::opacity_threshold, 0, 1}},
    {{"specTrans", &P::spec_trans, 0, 1}},
    {{"thin", &P::thin}},
    {{"flatness", &P::flatness, 0, 1}},
    {{"diffTrans", &P::diff_trans, 0, 2}},
    {{"diffTransColor", &P::diff_trans_color, 0, 1}, Texels::colors},
    {{"attenuationColor", &P::attenuation_color, 0, 1}, Texels::colors},
    {{"attenuationDistance", &P::attenuation_distance, 0, kUnbounded}},
    {{"priority", &P::priority, 0, 255}},
    {{"dispersion", &P::dispersion, 0, 20}},
    {{"iridescence", &P::iridescence, 0, 1}},
    {{"iridescenceIor", &P::iridescence_ior, 1, 4}},
    {{"iridescenceThickness", &P::iridescence_thickness, 0, kUnbounded}},
});

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

DisneyParameters DisneyMaterial::evaluate(const HitPrimvars& at) const {
  DisneyParameters p = constants;
  if (textures.empty()) return p;
  for (const MaterialTexture& texture : textures) multiply(texture, at, &p);
  // After all of them: the product counts, not its steps.
  for (const MaterialTexture& texture : textures)
    for (const MaterialTexture::Use& use : texture.uses) clamp_member(*use.parameter, &p);
  return p;
}

bool DisneyMaterial::varies(Rgb DisneyParameters::*parameter) const {
  return any_use(textures, parameter);
}
bool DisneyMaterial::varies(float DisneyParameters::*parameter) const {
  return any_use(textures, parameter);
}

bool DisneyMaterial::is_partly_opaque() const {
  return constants.opacity < 1 || varies(&P::opacity);
}

float DisneyMaterial::coverage(const HitPrimvars& at) const {
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

std::vector<const Texture*> DisneyMaterial::images() const {
  std::vector<const Texture*> all;
  for (const MaterialTexture& texture : textures)
    if (texture.lookup.image) all.push_back(texture.lookup.image.get());
  for (const auto* map : {&normal_map, &coat_normal_map})
    if (*map && (*map)->image) all.push_back((*map)->image.get());
  if (displacement) all.push_back(displacement->texture.image.get());
  return all;
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
