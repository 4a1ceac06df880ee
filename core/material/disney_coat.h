// Coat: a clear layer over the whole surface, GGX with alpha = roughness^2 and the full strength of its Fresnel
// reflection, as KHR_materials_clearcoat defines it for ior 1.5. It takes the place of Burley's clearcoat, which is a
// quarter as strong and dims nothing. Light that passes it takes its colour, and its darkening (OpenPBR 1.1.1, "Coat").
//
// The coat has a normal of its own: with a normal map on the base alone it is the surface's. Its f is reciprocal, and
// light counts by the cosine to that normal, as in the glTF Sample Viewer (getPunctualRadianceClearCoat) and in Cycles,
// where each closure counts light by its own normal. So its reflection does not depend on the base's normal map.
#pragma once

#include "core/material/disney_parameters.h"
#include "core/material/disney_specular.h"
#include "core/math/frame.h"

namespace alabaster {

struct DisneyCoat {
  float weight = 0;  // the parameter `coat`, in [0,1]; 0: there is no coat
  float f0 = 0.04f, f90 = 1;
  /// What it leaves of light each time that passes, beside what it reflects: the square root of what it leaves of light
  /// that comes back from below.
  Rgb passage{1.0f};
  DisneySpecular layer;
  Frame frame;             // about the coat's own normal
  Vec3f surface{0, 0, 1};  // the surface's normal
  bool tilted = false;     // against the normal of the other lobes

  static DisneyCoat from(const DisneyParameters& p) {
    const float alpha = std::max(kMinAlpha, sqr(std::max(p.coat_roughness, p.least_roughness)));
    const double root = (double(p.coat_ior) - 1) / (double(p.coat_ior) + 1);
    const auto f0 = static_cast<float>(root * root);
    const float f90 = f90_of(f0);
    const bool tilted = p.coat_normal.z < 1;
    return {p.coat,
            f0,
            f90,
            p.coat_color == Rgb(1.0f) && p.coat_darkening == 0 ? Rgb(1.0f) : passage_of(p, f0),
            {Rgb(f0 * p.coat), Rgb(f90 * p.coat), {alpha, alpha}},
            tilted ? frame_from_normal(p.coat_normal) : Frame(),
            p.surface_normal,
            tilted};
  }

  /// OpenPBR 1.1.1, "Coat", "Absorption" and "Darkening": K is the share of light from below that a smooth coat sends
  /// back, E the albedo of what lies below.
  static Rgb passage_of(const DisneyParameters& p, float f0) {
    const float k = 1 - (1 - f0) / sqr(p.coat_ior);
    const float walked = p.thin ? 0 : p.subsurface_weight * (1 - p.metallic);
    const Rgb e = lerp(p.base_color, p.medium_albedo(), walked);
    Rgb passage;
    for (int c = 0; c < 3; ++c) {
      const float darkened = lerp(1.0f, (1 - k) / (1 - e[c] * k), p.coat * p.coat_darkening);
      passage[c] = std::sqrt(lerp(1.0f, p.coat_color[c], p.coat) * darkened);
    }
    return passage;
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
  float passed(float cosine) const { return std::max(0.0f, 1 - weight * lerp(f0, f90, schlick_weight(cosine))); }
  /// Factor of lobes that reflect into all directions: reciprocal, and a Lambertian base keeps the albedo times
  /// passed(wo.z) that the extension gives it (as Kelemen and Szirmay-Kalos 2001 normalise a matte base). The mean of
  /// Schlick's reflectance over the hemisphere is f0 + (f90 - f0) / 21.
  float over_diffuse(const Vec3f& wo, const Vec3f& wi) const { return passed(wo) * passed(wi) / mean_passed(); }
  /// The share of light from everywhere that passes.
  float mean_passed() const { return 1 - weight * (f0 + (f90 - f0) / 21); }
  /// The same by the exit lobe of subsurface, whose mean of Schlick's weight is (1/21 - 1/132) / (41/42).
  float mean_passed_at_exit() const { return 1 - weight * (f0 + (f90 - f0) * 37 / 902); }
  /// Factor of lobes about the mirror direction: the same there, and reciprocal.
  float over_specular(const Vec3f& wo, const Vec3f& wi) const { return std::sqrt(passed(wo) * passed(wi)); }
};

}  // namespace alabaster
