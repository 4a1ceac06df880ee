#include "core/material/disney_material.h"

#include <algorithm>

namespace alabaster {
namespace {

using P = DisneyParameters;
using M = DisneyMaterial;

constexpr std::array<MaterialParameter, 15> kParameters{{
    {{"baseColor", &P::base_color, 0, 1}, &M::base_color_map, Texels::colors},
    {{"metallic", &P::metallic, 0, 1}},
    {{"roughness", &P::roughness, 0, 1}},
    {{"anisotropic", &P::anisotropic, 0, 1}},
    {{"specularTint", &P::specular_tint, 0, 1}},
    {{"ior", &P::ior, 1, 4}},
    {{"specular", &P::specular, 0, 1}},
    {{"specularColor", &P::specular_color, 0, kUnbounded}},
    {{"sheen", &P::sheen, 0, 1}},
    {{"sheenTint", &P::sheen_tint, 0, 1}},
    {{"clearcoat", &P::clearcoat, 0, 1}},
    {{"clearcoatGloss", &P::clearcoat_gloss, 0, 1}},
    {{"scatterDistance", &P::scatter_distance, 0, kUnbounded}, &M::scatter_distance_map},
    {{"scatterAnisotropy", &P::scatter_anisotropy, -0.9, 0.9}},
    {{"emission", &P::emission, 0, kUnbounded}},
}};

constexpr bool is_textured(const MaterialParameter& parameter) {
  return parameter.map != nullptr;
}

// The rows with a map alone: no hit pays for the others.
constexpr auto kTextured = [] {
  std::array<MaterialParameter, std::count_if(kParameters.begin(), kParameters.end(), is_textured)> rows;
  std::copy_if(kParameters.begin(), kParameters.end(), rows.begin(), is_textured);
  return rows;
}();

Rgb clamped(const Rgb& value, const MaterialParameter& parameter, const Rgb& fallback) {
  constexpr double kLargest = std::numeric_limits<float>::max();
  const auto low = static_cast<float>(parameter.minimum),
             high = static_cast<float>(std::min(parameter.maximum, kLargest));
  Rgb c;
  for (int i = 0; i < 3; ++i) c[i] = std::isfinite(value[i]) ? std::clamp(value[i], low, high) : fallback[i];
  return c;
}

}  // namespace

DisneyParameters DisneyMaterial::evaluate(const Vec2f& uv) const {
  DisneyParameters p = constants;
  for (const MaterialParameter& parameter : kTextured)
    if (const Texture* map = (this->*parameter.map).get()) {
      const auto member = std::get<Rgb P::*>(parameter.member);
      p.*member = clamped(p.*member * map->rgb(uv), parameter, DisneyParameters().*member);
    }
  return p;
}

std::vector<const Texture*> DisneyMaterial::textures() const {
  std::vector<const Texture*> all;
  for (const MaterialParameter& parameter : kTextured)
    if (const Texture* map = (this->*parameter.map).get()) all.push_back(map);
  return all;
}

std::span<const MaterialParameter> material_parameters() {
  return kParameters;
}

}  // namespace alabaster
