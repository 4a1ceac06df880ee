// A sheet of a dielectric, too thin to be seen to refract (Burley 2015, section 5.3, "thin surface"; the thin surfaces
// of KHR_materials_transmission): its reflection, and the same lobe mirrored to the other side with a roughness of its
// own. It has two faces, and all orders of light between them count (OpenPBR's thin walls; Kulla and Conty 2017): a
// smooth sheet passes T = tint (1 - F)^2 / (1 - F^2) and reflects F (1 + T), as a slab of the solid does. f has no
// cosine; pdf per solid angle. Reciprocal; energy <= 1, for f |wi.z| / pdf is G1(wi) times what passes and is
// reflected.
#pragma once

#include "core/material/bsdf_value.h"
#include "core/material/dielectric_boundary.h"
#include "core/material/microfacet.h"

namespace alabaster {

struct DisneyThinDielectric {
  DielectricBoundary boundary;
  Ggx ggx, ggx_through;

  /// The roughness that light sees on its way through: Burley's fit, which a straight line takes to no effect at ior 1,
  /// as KHR_materials_transmission asks.
  static float roughness_through(float roughness, float ior) {
    return roughness * std::clamp(std::min(0.65f * ior - 0.35f, 2 * ior - 2), 0.0f, 1.0f);
  }
  /// Light passes without a change of direction: the lobe has reflection alone.
  bool is_straight() const { return std::max(ggx_through.alpha_x, ggx_through.alpha_y) <= kMinAlpha; }
  /// The share of samples that go straight on.
  float chance_of_straight(const Vec3f& wo) const { return is_straight() ? 1 - chance(wo) : 0; }

  LobeValue evaluate(const Vec3f& wo, const Vec3f& wi) const {
    const bool reflects = wi.z > 0;
    if (!(wo.z > 0) || wi.z == 0 || (is_straight() && !reflects)) return {};
    const Vec3f mirrored(wi.x, wi.y, std::abs(wi.z));
    const auto facet = mirror_facet(wo, mirrored);
    if (!facet) return {};
    const Ggx& lobe = reflects ? ggx : ggx_through;
    const auto shares = boundary.shares(facet->cos_d);
    const float pdf = 0.25f * lobe.d(facet->wm) * lobe.g1_over_cos(wo);
    return {(reflects ? shares.reflected : shares.passed) * (pdf * lobe.g1_over_cos(mirrored)),
            pdf * (reflects ? chance(wo) : 1 - chance(wo))};
  }

  /// `u_choice` chooses between the sides, at least chance_of_straight(). Empty where the direction lands on the wrong
  /// one.
  std::optional<Vec3f> sample(const Vec3f& wo, float u_choice, const Vec2f& u) const {
    const bool reflects = u_choice >= 1 - chance(wo);
    const Vec3f wi = normalize(reflect_about(wo, (reflects ? ggx : ggx_through).sample(wo, u)));
    if (!(wi.z > 0)) return std::nullopt;
    return reflects ? wi : Vec3f(wi.x, wi.y, -wi.z);
  }

  /// Estimate of what leaves, either way.
  Rgb albedo(const Vec3f& wo) const { return boundary.albedo(wo.z); }

 private:
  /// The probability of reflection: the two sides have facets of their own, so the choice comes first. Tilted facets
  /// reflect and pass other shares than the flat one.
  float chance(const Vec3f& wo) const {
    const float flat = boundary.shares(wo.z).chance;
    return is_straight() ? flat : std::clamp(flat, 0.1f, 0.9f);
  }
};

}  // namespace alabaster
