// Schlick's approximation of Fresnel reflectance, and the colours that lobes are made of.
#pragma once

#include <algorithm>

#include "core/color/rgb.h"
#include "core/math/vector.h"

namespace alabaster {

/// (1 - cos)^5 (Schlick 1994, "An Inexpensive BRDF Model for Physically-Based Rendering"), in [0,1] for any finite
/// cosine.
inline float schlick_weight(float cos_theta) {
  const float m = std::clamp(1 - cos_theta, 0.0f, 1.0f);
  const float m2 = m * m;
  return m2 * m2 * m;
}

/// From f0 at normal to f90 at grazing incidence.
inline Rgb schlick(const Rgb& f0, const Rgb& f90, float cos_theta) {
  return lerp(f0, f90, schlick_weight(cos_theta));
}

/// ((ior-1)/(ior+1))^2: reflectance at normal incidence of a dielectric in air, ior >= 1.
inline float f0_from_ior(float ior) {
  return sqr((ior - 1) / (ior + 1));
}

/// Snell's law: the cosine of the refracted direction, 0 under total reflection. Arguments as below. In this form
/// nothing cancels where a boundary of eta near 1 is seen at a grazing angle.
inline float cosine_refracted(float cosine, float eta) {
  return std::sqrt(std::max(0.0f, (eta - 1) * (eta + 1) + sqr(cosine))) / eta;
}

/// Reflectance of a smooth dielectric surface for unpolarised light: Fresnel's equations. `eta`: the index of the far
/// side over that of the side that the light comes from; `cosine` > 0 of incidence. 1 under total reflection.
inline float fresnel_dielectric(float cosine, float eta) {
  const float cos_t = cosine_refracted(cosine, eta);
  if (!(cos_t > 0)) return 1;
  const float parallel = (eta * cosine - cos_t) / (eta * cosine + cos_t);
  const float perpendicular = (cosine - eta * cos_t) / (cosine + eta * cos_t);
  return 0.5f * (sqr(parallel) + sqr(perpendicular));
}

/// The hue and saturation of a colour at luminance one, which specularTint and sheenTint mix with white. The luminance
/// weights .3, .6, .1 are those of the published model (Burley 2012) and belong to its look. White for black.
inline Rgb tint(const Rgb& color) {
  const float y = 0.3f * color.r + 0.6f * color.g + 0.1f * color.b;
  return y > 0 ? Rgb(color.r / y, color.g / y, color.b / y) : Rgb(1.0f);
}

inline Rgb clamp01(const Rgb& c) {
  return {std::clamp(c.r, 0.0f, 1.0f), std::clamp(c.g, 0.0f, 1.0f), std::clamp(c.b, 0.0f, 1.0f)};
}

/// Weight of a lobe of this albedo when one is chosen: the plain mean, because weights by luminance leave a blue lobe
/// with samples fourteen times too heavy.
inline float choice_weight(const Rgb& c) {
  return (c.r + c.g + c.b) * (1.0f / 3.0f);
}

/// The probability of choosing a lobe of this weight. 0 where the inverse of a pdf of it could overflow: the random
/// number 0 chooses a lobe of any positive probability.
inline float chance_of(float weight, float total) {
  constexpr float kLeast = 1e-20f;
  return weight >= kLeast * total ? weight / total : 0;
}

}  // namespace alabaster
