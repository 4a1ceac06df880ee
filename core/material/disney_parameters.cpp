#include "core/material/disney_parameters.h"

#include <limits>

namespace alabaster {
namespace {

float clamped(float value, float low, float high, float otherwise) {
  return std::isfinite(value) ? std::clamp(value, low, high) : otherwise;
}

Rgb clamped(const Rgb& value, float high, const Rgb& otherwise) {
  return {clamped(value.r, 0, high, otherwise.r), clamped(value.g, 0, high, otherwise.g),
          clamped(value.b, 0, high, otherwise.b)};
}

}  // namespace

DisneyParameters clamp_to_ranges(const DisneyParameters& parameters) {
  const DisneyParameters defaults;
  constexpr float kUnbounded = std::numeric_limits<float>::max();
  DisneyParameters p = parameters;
  p.base_color = clamped(p.base_color, 1, defaults.base_color);
  p.metallic = clamped(p.metallic, 0, 1, defaults.metallic);
  p.roughness = clamped(p.roughness, 0, 1, defaults.roughness);
  p.anisotropic = clamped(p.anisotropic, 0, 1, defaults.anisotropic);
  p.specular_tint = clamped(p.specular_tint, 0, 1, defaults.specular_tint);
  p.ior = clamped(p.ior, 1, 4, defaults.ior);
  p.specular = clamped(p.specular, 0, 1, defaults.specular);
  p.specular_color = clamped(p.specular_color, kUnbounded, defaults.specular_color);
  p.sheen = clamped(p.sheen, 0, 1, defaults.sheen);
  p.sheen_tint = clamped(p.sheen_tint, 0, 1, defaults.sheen_tint);
  p.clearcoat = clamped(p.clearcoat, 0, 1, defaults.clearcoat);
  p.clearcoat_gloss = clamped(p.clearcoat_gloss, 0, 1, defaults.clearcoat_gloss);
  p.scatter_distance = clamped(p.scatter_distance, kUnbounded, defaults.scatter_distance);
  p.scatter_anisotropy = clamped(p.scatter_anisotropy, -0.9f, 0.9f, defaults.scatter_anisotropy);
  p.emission = clamped(p.emission, kUnbounded, defaults.emission);
  return p;
}

}  // namespace alabaster
