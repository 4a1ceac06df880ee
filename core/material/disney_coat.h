// Coat: a clear layer of ior 1.5 over the whole surface, GGX with alpha = roughness^2 and the full strength of its
// Fresnel reflection, as KHR_materials_clearcoat defines it. It takes the place of Burley's clearcoat, which is a
// quarter as strong and dims nothing.
//
// The coat has a normal of its own: with a normal map on the base alone it is the surface's. Its f is reciprocal, and
// light counts by the cosine to that normal, as in the glTF Sample Viewer (getPunctualRadianceClearCoat) and in Cycles,
// where each closure counts light by its own normal. So its reflection does not depend on the base's normal map.
#pragma once

#include "core/material/disney_specular.h"
#include "core/math/frame.h"

namespace alabaster {

struct DisneyCoat {
  float weight = 0;  // the parameter `coat`, in [0,1]; 0: there is no coat
  DisneySpecular layer;
  Frame frame;             // about the coat's own normal
  Vec3f surface{0, 0, 1};  // the surface's normal
  bool tilted = false;     // against the normal of the other lobes

  static DisneyCoat from(float coat, float roughness, const Vec3f& normal = {0, 0, 1},
                         const Vec3f& surface = {0, 0, 1}) {
    const float alpha = std::max(kMinAlpha, sqr(roughness));
    const bool tilted = normal.z < 1;
    return {coat,
            {Rgb(0.04f * coat), Rgb(coat), {alpha, alpha}},
            tilted ? frame_from_normal(normal) : Frame(),
            surface,
            tilted};
  }

  /// f times the cosine to the coat's own normal. `wi` may lie below the horizon of the other lobes, where reaches(wi).
  BsdfValue evaluate(const Vec3f& wo, const Vec3f& wi) const {
    const Vec3f local = tilted ? frame.to_local(wi) : wi;
    const LobeValue value = layer.evaluate(tilted ? frame.to_local(wo) : wo, local);
    return {value.f * (reaches(wi) ? local.z : 0), value.pdf};
  }
  /// True if the coat, but for its own normal, reflects to `wi`.
  bool reaches(const Vec3f& wi) const { return tilted ? dot(wi, surface) > 0 : wi.z > 0; }
  /// Empty where the direction goes below the coat's horizon.
  std::optional<Vec3f> sample(const Vec3f& wo, const Vec2f& u) const {
    const Vec3f local = frame.to_local(wo);
    if (!(local.z > 0)) return std::nullopt;
    const std::optional<Vec3f> wi = layer.sample(local, u);
    return wi ? std::optional(frame.to_world(*wi)) : std::nullopt;
  }
  Rgb albedo(const Vec3f& wo) const { return layer.albedo(frame.to_local(wo)); }

  /// The share of light from or to `w` that passes the coat.
  float passed(const Vec3f& w) const { return passed(frame.to_local(w).z); }
  float passed(float cosine) const { return std::max(0.0f, 1 - weight * lerp(0.04f, 1.0f, schlick_weight(cosine))); }
  /// Factor of lobes that reflect into all directions: reciprocal, and a Lambertian base keeps the albedo times
  /// passed(wo.z) that the extension gives it (as Kelemen and Szirmay-Kalos 2001 normalise a matte base). The mean of
  /// Schlick's reflectance over the hemisphere is .04 + .96 / 21.
  float over_diffuse(const Vec3f& wo, const Vec3f& wi) const { return passed(wo) * passed(wi) / mean_passed(); }
  /// The share of light from everywhere that passes.
  float mean_passed() const { return 1 - weight * (0.04f + 0.96f / 21); }
  /// The same by the exit lobe of subsurface, whose mean of Schlick's weight is (1/21 - 1/132) / (41/42).
  float mean_passed_at_exit() const { return 1 - weight * (0.04f + 0.96f * 37 / 902); }
  /// Factor of lobes about the mirror direction: the same there, and reciprocal.
  float over_specular(const Vec3f& wo, const Vec3f& wi) const { return std::sqrt(passed(wo) * passed(wi)); }
};

}  // namespace alabaster
