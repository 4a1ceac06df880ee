// A rough boundary of two dielectrics: anisotropic GGX facets that reflect and refract (Walter et al. 2007,
// "Microfacet Models for Refraction through Rough Surfaces", equations 20 and 21), visible normals sampled (Heitz
// 2018).
//
//   reflection  F D G1(wo) G1(wi) / (4 |wo.z wi.z|)
//   refraction  (1-F) D G1(wo) G1(wi) |wo.wm| |wi.wm| / (|wo.z wi.z| (wo.wm + eta wi.wm)^2)
//
// f is of radiance, which refraction into a medium of index eta multiplies by eta^2: Walter's f over eta^2, so that
// f(wo, wi) / n_o^2 is reciprocal (Veach 1997, section 5.2). f has no cosine; pdf per solid angle. Energy <= 1: the
// weight f |wi.z| / pdf is G1(wi), over eta^2 for refraction, times the tints.
#pragma once

#include "core/material/bsdf_value.h"
#include "core/material/dielectric_boundary.h"
#include "core/material/microfacet.h"

namespace alabaster {

struct DisneyDielectric {
  DielectricBoundary boundary;
  Ggx ggx;

  /// Float cannot tell so little refraction from none. Then all light goes straight on, and the lobe has no other.
  bool is_straight() const { return std::abs(boundary.eta - 1) < 1e-4f; }
  /// The share of samples that go straight on.
  float chance_of_straight(const Vec3f&) const { return is_straight() ? 1 : 0; }

  LobeValue evaluate(const Vec3f& wo, const Vec3f& wi) const {
    if (!(wo.z > 0) || wi.z == 0 || is_straight()) return {};
    return wi.z > 0 ? reflected(wo, wi) : refracted(wo, wi);
  }

  /// `u_choice` chooses between reflection and refraction. Empty where the direction lands on the wrong side of the
  /// surface: light that a further bounce between facets would carry.
  std::optional<Vec3f> sample(const Vec3f& wo, float u_choice, const Vec2f& u) const {
    const Vec3f wm = ggx.sample(wo, u);
    const float cosine = dot(wo, wm);
    if (!(cosine > 0)) return std::nullopt;
    const bool reflects = u_choice < boundary.shares(cosine).chance;
    const float inv_eta = 1 / boundary.eta;
    const Vec3f wi = reflects ? reflect_about(wo, wm)
                              : wm * (cosine * inv_eta - cosine_refracted(cosine, boundary.eta)) - wo * inv_eta;
    if (!(reflects ? wi.z > 0 : wi.z < 0)) return std::nullopt;
    return normalize(wi);
  }

  /// Estimate of what leaves, either way.
  Rgb albedo(const Vec3f& wo) const { return boundary.albedo(wo.z); }

 private:
  LobeValue reflected(const Vec3f& wo, const Vec3f& wi) const {
    const auto facet = mirror_facet(wo, wi);
    if (!facet) return {};
    const auto shares = boundary.shares(facet->cos_d);
    const float pdf = 0.25f * ggx.d(facet->wm) * ggx.g1_over_cos(wo);
    return {shares.reflected * (pdf * ggx.g1_over_cos(wi)), pdf * shares.chance};
  }

  LobeValue refracted(const Vec3f& wo, const Vec3f& wi) const {
    const Vec3f sum = wo + wi * boundary.eta;
    const float l2 = dot(sum, sum);
    if (!(l2 > 1e-30f)) return {};
    const Vec3f wm = sum * ((sum.z > 0 ? 1 : -1) / std::sqrt(l2));
    const float cos_o = dot(wo, wm), cos_i = -dot(wi, wm);
    if (!(cos_o > 0 && cos_i > 0)) return {};
    const auto shares = boundary.shares(cos_o);
    // D_v(wm) |dwm / dwi|, where (wo.wm + eta wi.wm)^2 = |wo + eta wi|^2.
    const float visible = ggx.d(wm) * ggx.g1_over_cos(wo) * cos_o * cos_i / l2;
    return {shares.passed * (visible * ggx.g1_over_cos({wi.x, wi.y, -wi.z})),
            visible * sqr(boundary.eta) * (1 - shares.chance)};
  }
};

}  // namespace alabaster
