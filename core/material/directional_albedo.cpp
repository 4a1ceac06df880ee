#include "core/material/directional_albedo.h"

#include "core/material/albedo_table.h"
#include "core/material/disney_clearcoat.h"
#include "core/material/disney_diffuse.h"
#include "core/material/disney_sheen.h"
#include "core/material/fresnel.h"

namespace alabaster {
namespace {

// Cosines are spaced by their squares: albedos change fastest near the horizon. That is left out itself, where a lobe's
// f may be infinite.
float cosine_at(float x) {
  return std::max(1e-4f, sqr(x));
}
float place_of(float cosine) {
  return std::sqrt(std::clamp(cosine, 0.0f, 1.0f));
}

Vec3f direction(float cosine) {
  return {safe_sqrt(1 - sqr(cosine)), 0, cosine};
}

// Midpoints of a grid over the unit square; the mean of f(u).
template <int kColumns, int kRows, class F>
auto mean_over_square(const F& f) {
  decltype(f(Vec2f())) sum(0);
  for (int row = 0; row < kRows; ++row)
    for (int column = 0; column < kColumns; ++column)
      sum += f(Vec2f((static_cast<float>(column) + 0.5f) / kColumns, (static_cast<float>(row) + 0.5f) / kRows));
  return sum * (1.0f / (kColumns * kRows));
}

// Int f wi.z dwi over the hemisphere, of a lobe that is symmetric about the plane of incidence: f(wo, wi). Points are
// dense near the horizon: wi.z is u.x^2.
template <class F>
float cosine_weighted(float cosine, const F& f) {
  const Vec3f wo = direction(cosine);
  return kPi * mean_over_square<48, 48>([&](const Vec2f& u) {
           const float z = sqr(u.x), r = safe_sqrt(1 - sqr(z)), phi = kPi * u.y;
           return f(wo, Vec3f(r * std::cos(phi), r * std::sin(phi), z)) * (4 * u.x * z);
         });
}

// By visible normals: f cos / pdf is G1(wi). Facets tilt steeply where u.x is near 1, so points are dense there.
Vec2f integrate_ggx(const Vec3f& wo, const Ggx& ggx) {
  return mean_over_square<24, 8>([&](const Vec2f& u) {
    const float rest = 1 - u.x;
    const Vec3f wm = ggx.sample(wo, {1 - rest * rest * rest, u.y});
    const Vec3f wi = reflect_about(wo, wm);
    if (!(wi.z > 0)) return Vec2f(0, 0);
    const float g1 = 3 * rest * rest * wi.z * ggx.g1_over_cos(wi);
    return Vec2f(g1, g1 * schlick_weight(dot(wo, wm)));
  });
}

// Alphas from the sharpest to 1 are spaced by their squares.
float alpha_at(float y) {
  return sqr(lerp(std::sqrt(kMinAlpha), 1.0f, y));
}
float place_of_alpha(float alpha) {
  return (std::sqrt(alpha) - std::sqrt(kMinAlpha)) / (1 - std::sqrt(kMinAlpha));
}

// Near the horizon straight lines between corners run below the albedo by this share. Who keeps energy must not think
// it too low.
template <class Albedo>
Albedo raised(const Albedo& albedo, float cosine, float share) {
  return cosine < 0.05f ? albedo * (1 + share) : albedo;
}

using GgxTable = AlbedoTable<Vec2f, 48, 32>;
const GgxTable& ggx_table() {
  static const GgxTable table([](const GgxTable::Place& at) {
    const float alpha = alpha_at(at[1]);
    const float cosine = cosine_at(at[0]);
    return raised(integrate_ggx(direction(cosine), {alpha, alpha}), cosine, 0.003f);
  });
  return table;
}

// Samples of GTR1 by D wm.z: f cos / pdf = F G 4 cos_d wi.z / (4 wo.z wi.z wm.z).
float integrate_clearcoat(float cosine, float alpha) {
  const DisneyClearcoat lobe{1, {alpha}};
  const Vec3f wo = direction(cosine);
  return mean_over_square<32, 16>([&](const Vec2f& u) {
    const auto wi = lobe.sample(wo, {u.x, 0.5f * u.y});
    if (!wi) return 0.0f;
    const BsdfValue value = lobe.evaluate(wo, *wi);
    return value.pdf > 0 ? value.f.r * wi->z / value.pdf : 0.0f;
  });
}

// Aspects, the roots of the ratios of alphas, are spaced by their logarithms down to this one.
constexpr float kLeastAspect = 0.03f;

Vec2f integrate_anisotropic(const std::array<float, 4>& at) {
  const float cosine = cosine_at(at[0]), sine = safe_sqrt(1 - sqr(cosine)), phi = 0.5f * kPi * at[3];
  const float alpha = alpha_at(at[1]), aspect = std::pow(kLeastAspect, at[2]);
  const Ggx ggx{std::max(kMinAlpha, alpha / aspect), std::max(kMinAlpha, alpha * aspect)};
  return raised(integrate_ggx({sine * std::cos(phi), sine * std::sin(phi), cosine}, ggx), cosine, 0.03f);
}

// Indices are spaced so that those of both sides of a boundary are alike.
constexpr float kLeastPlaceOfEta = 0.2f;
float eta_at(float y) {
  const float place = lerp(kLeastPlaceOfEta, 1 - kLeastPlaceOfEta, y);
  return place / (1 - place);
}
float place_of_eta(float eta) {
  return (eta / (1 + eta) - kLeastPlaceOfEta) / (1 - 2 * kLeastPlaceOfEta);
}

// By visible normals, as integrate_ggx().
Vec2f integrate_dielectric(float cosine, float alpha, float eta) {
  const Vec3f wo = direction(cosine);
  const Ggx ggx{alpha, alpha};
  return mean_over_square<24, 8>([&](const Vec2f& u) {
    const float rest = 1 - u.x, weight = 3 * rest * rest;
    const Vec3f wm = ggx.sample(wo, {1 - rest * rest * rest, u.y});
    const float cos_d = dot(wo, wm);
    if (!(cos_d > 0)) return Vec2f(0, 0);
    const float fresnel = fresnel_dielectric(cos_d, eta);
    const auto left = [&](const Vec3f& wi) { return wi.z > 0 ? weight * wi.z * ggx.g1_over_cos(wi) : 0; };
    const Vec3f through = wm * (cos_d / eta - cosine_refracted(cos_d, eta)) - wo / eta;
    return Vec2f(fresnel * left(reflect_about(wo, wm)), (1 - fresnel) * left({through.x, through.y, -through.z}));
  });
}

}  // namespace

GgxAlbedo ggx_albedo(const Vec3f& wo, const Ggx& ggx) {
  const float alpha = std::sqrt(ggx.alpha_x * ggx.alpha_y);
  if (ggx.alpha_x == ggx.alpha_y) {
    const Vec2f value = ggx_table().at({place_of(wo.z), place_of_alpha(alpha)});
    return {value.x, value.y};
  }
  static const AlbedoTable<Vec2f, 24, 12, 8, 6> table(integrate_anisotropic);
  const float aspect = std::sqrt(ggx.alpha_y / ggx.alpha_x);
  const Vec2f value = table.at({place_of(wo.z), place_of_alpha(alpha), std::log(aspect) / std::log(kLeastAspect),
                                std::atan2(std::abs(wo.y), std::abs(wo.x)) / (0.5f * kPi)});
  return {value.x, value.y};
}

float mean_ggx_albedo(float alpha) {
  static const AlbedoTable<float, 32> table([](const std::array<float, 1>& at) {
    constexpr int kCosines = 256;
    float sum = 0;
    for (int i = 0; i < kCosines; ++i) {
      const float cosine = (static_cast<float>(i) + 0.5f) / kCosines;
      sum += 2 * cosine * ggx_table().at({place_of(cosine), at[0]}).x / kCosines;
    }
    return sum;
  });
  return table.at({place_of_alpha(alpha)});
}

DielectricAlbedo dielectric_albedo(float cosine, float alpha, float eta) {
  constexpr float kSmooth = 0.01f;  // Fresnel's equations change too fast for a table
  if (alpha < kSmooth) {
    const float fresnel = fresnel_dielectric(cosine, eta);
    return {fresnel, 1 - fresnel};
  }
  static const AlbedoTable<Vec2f, 24, 16, 24> table([](const std::array<float, 3>& at) {
    return integrate_dielectric(cosine_at(at[0]), alpha_at(at[1]), eta_at(at[2]));
  });
  const Vec2f value = table.at({place_of(cosine), place_of_alpha(alpha), place_of_eta(eta)});
  return {value.x, value.y};
}

float clearcoat_albedo(float cosine, float gtr1_alpha) {
  static const AlbedoTable<float, 48, 4> table(
      [](const std::array<float, 2>& at) { return integrate_clearcoat(cosine_at(at[0]), lerp(0.001f, 0.1f, at[1])); });
  return table.at({place_of(cosine), (gtr1_alpha - 0.001f) / 0.099f});
}

float sheen_albedo(float cosine) {
  static const AlbedoTable<float, 32> table([](const std::array<float, 1>& at) {
    return cosine_weighted(
        cosine_at(at[0]), [](const Vec3f& wo, const Vec3f& wi) { return DisneySheen{Rgb(1.0f)}.evaluate(wo, wi).f.r; });
  });
  return table.at({place_of(cosine)});
}

float flat_albedo(float cosine, float roughness) {
  static const AlbedoTable<float, 64, 8> table([](const std::array<float, 2>& at) {
    const float cosine = cosine_at(at[0]);
    const auto flat = [&](const Vec3f& wo, const Vec3f& wi) { return DisneyDiffuse::flat(wo, wi, at[1]); };
    return raised(cosine_weighted(cosine, flat), cosine, 0.003f);
  });
  return table.at({place_of(cosine), roughness});
}

}  // namespace alabaster
