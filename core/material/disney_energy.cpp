// How DisneyBsdf keeps energy: the albedos of its lobes along one direction, and the shares that they keep.
#include "core/material/directional_albedo.h"
#include "core/material/disney_bsdf.h"

namespace alabaster {
namespace {

Rgb greater(const Rgb& a, const Rgb& b) {
  return {std::max(a.r, b.r), std::max(a.g, b.g), std::max(a.b, b.b)};
}

Rgb albedo_of(const DisneySpecular& lobe, const Vec3f& w) {
  const GgxAlbedo facets = ggx_albedo(w, lobe.ggx);
  const Rgb bare = lobe.f0 * (facets.white - facets.schlick) + lobe.f90 * facets.schlick;
  if (!(lobe.film.share > 0)) return bare;
  // Rough facets lean towards the viewer. The change by a film has no mean in closed form: the largest at cosines that
  // slopes of up to four times the roughness give.
  const auto change = [&](float cosine) { return lobe.fresnel(cosine) - schlick(lobe.f0, lobe.f90, cosine); };
  const float alpha = std::max(lobe.ggx.alpha_x, lobe.ggx.alpha_y);
  Rgb film = change(w.z);
  for (const float slopes : {0.25f, 0.5f, 1.0f, 2.0f, 4.0f})
    film = greater(film, change(lerp(w.z, 1.0f, std::min(1.0f, slopes * alpha))));
  return greater(bare + film * facets.white, Rgb(0.0f));
}

// How much more of the Lambert term's light passes a coat than of light that leaves evenly: both keep to steep
// directions. The mean of p (1-.5F) over that of p and of 1-.5F, where p = 1 - k (f0 + (f90 - f0) F) is the coat's
// share; the means of F and F^2 are 1/21 and 1/66.
float lambert_under_coat(const DisneyCoat& coat) {
  constexpr float f = 1.0f / 21, f2 = 1.0f / 66;
  const float k = coat.weight, rise = coat.f90 - coat.f0;
  const float both = (1 - coat.f0 * k) * (1 - 0.5f * f) - rise * k * (f - 0.5f * f2);
  return both / ((1 - k * (coat.f0 + rise * f)) * (1 - 0.5f * f));
}

// The lobe reflects of the light along `w` what it would with facets of `own`.
void keep_albedo_of(const Ggx& own, const Vec3f& w, DisneySpecular* lobe) {
  if (lobe->film.share > 0 || !(w.z > 0)) return;  // a film's colours are no function of a reflectance above 1
  DisneySpecular narrow = *lobe;
  narrow.ggx = own;
  const Rgb kept = albedo_of(narrow, w), widened = albedo_of(*lobe, w);
  for (int c = 0; c < 3; ++c) {
    if (!(widened[c] > 0)) continue;
    lobe->f0[c] *= kept[c] / widened[c];
    lobe->f90[c] *= kept[c] / widened[c];
  }
}

float over(float room, float share) {
  return share > 0 ? std::max(0.0f, room) / share : 0;
}

}  // namespace

// Facets that are rougher than the material's reflect as much of the light along wo as the material's would: their
// Fresnel factor alone makes a grazing mirror brighter than a rough one.
void DisneyBsdf::keep_albedos(const DisneyParameters& p) {
  if (p.is_widened()) keep_albedo_of(disney_ggx(p.roughness, p.anisotropic), wo_, &specular_);
  if (coated()) {
    const float alpha = std::max(kMinAlpha, sqr(p.coat_roughness));
    keep_albedo_of({alpha, alpha}, layers_->coat.frame.to_local(wo_), &layers_->coat.layer);
  } else if (clearcoat_.strength > 0) {
    const float widened = clearcoat_albedo(wo_.z, clearcoat_.gtr1.alpha);
    const float own = clearcoat_albedo(wo_.z, DisneyClearcoat::from(1, p.clearcoat_gloss).gtr1.alpha);
    if (widened > 0) clearcoat_.strength *= own / widened;
  }
}

void DisneyBsdf::bound_energy(const DisneyParameters& p) {
  is_transparent_ = p.is_transparent();
  clear_ = nonmetal_ * p.spec_trans;
  beyond_ = p.diff_trans_color * (dielectric_ * 0.5f * p.diff_trans);
  if (energy_ == EnergyModel::conserving) add_several_facets(p);
  safe_cosine_ = least_safe_cosine();
  if (wo_.z < safe_cosine_) kept_ = kept_along(wo_);
}

float DisneyBsdf::least_safe_cosine() const {
  constexpr float kNone = 2;
  if (layers_ || specular_.film.share > 0 || diffuse_.flatness > 0) return kNone;
  const bool has_base = !is_black(diffuse_.retro_color) || !is_black(sheen_.color) || !is_black(beyond_);
  if (!has_base && clear_ == 0 && clearcoat_.strength == 0) return 0;  // facets alone give back what they receive
  if (!is_black(several_)) return kNone;
  // The walk takes the place of the Lambert term.
  const Rgb lambert = diffuse_.retro_color * DisneyDiffuse::lambert_albedo(1);
  const Rgb everywhere = lambert + beyond_ + specular_.f0 + Rgb(clear_);
  for (const SteepAlbedos& steep : kSteepAlbedos) {
    const Rgb most = everywhere + diffuse_.retro_color * DisneyDiffuse::retro_albedo(steep.cosine, diffuse_.roughness) +
                     sheen_.color * steep.sheen + specular_.f90 * steep.schlick +
                     Rgb(clearcoat_.strength * steep.clearcoat);
    if (max_component(most) <= 1) return steep.cosine;
  }
  return kNone;
}

// Kulla and Conty 2017, "Revisiting Physically Based Shading at Imageworks": a lobe of the light that single scattering
// loses, both ways, coloured by the facets that it met on average, F^2 E / (1 - F (1 - E)). Schlick's mean is
// f0 + (f90 - f0) / 21. A half metal is a mixture of two surfaces, and so is its lobe.
void DisneyBsdf::add_several_facets(const DisneyParameters& p) {
  const float mean = mean_ggx_albedo(specular_.ggx), lost = 1 - mean;
  if (!(lost > 1e-4f)) return;
  lost_ = lost_among_facets(wo_);
  const auto albedo = [&](float fresnel) { return sqr(fresnel) * mean / (1 - fresnel * lost); };
  for (int c = 0; c < 3; ++c) {
    const float of_metal = albedo(lerp(p.base_color[c], 1.0f, 1.0f / 21));
    several_of_metal_[c] = p.metallic * of_metal;
    several_albedo_[c] = lerp(albedo(specular_.mean_dielectric[c]), of_metal, p.metallic);
  }
  several_ = several_albedo_ * (1 / (kPi * lost));
}

float DisneyBsdf::lost_among_facets(const Vec3f& w) const {
  return std::max(0.0f, 1 - ggx_albedo(w, specular_.ggx).white);
}

Rgb DisneyBsdf::several_facets(const Vec3f& wi) const {
  return several_ * (lost_ * lost_among_facets(wi));
}

Rgb DisneyBsdf::base_albedo(const Vec3f& w) const {
  Rgb albedo = diffuse_.albedo(w);
  if (diffuse_.flatness > 0)
    albedo = lerp(albedo, diffuse_.retro_color * flat_albedo(w.z, diffuse_.roughness), diffuse_.flatness);
  if (!is_black(sheen_.color)) albedo += sheen_.color * sheen_albedo(w.z);
  if (coated()) albedo *= lambert_under_coat(layers_->coat);
  return albedo + beyond_;
}

Rgb DisneyBsdf::specular_albedo(const Vec3f& w) const {
  Rgb albedo = albedo_of(specular_, w);
  if (!is_black(several_)) albedo += several_albedo_ * lost_among_facets(w);
  if (clearcoat_.strength > 0 && !coated()) {
    // It lies over the fibres, which dim all else that is counted here.
    const float passed = fibrous() ? std::max(1e-6f, layers_->fibres.passed(w.z)) : 1;
    albedo += Rgb(clearcoat_.strength * clearcoat_albedo(w.z, clearcoat_.gtr1.alpha) / passed);
  }
  if (!coated()) return albedo;
  // DisneyCoat::over_specular() is at most this much above what coat.passed(w) leaves.
  return albedo * std::sqrt(layers_->coat.passed(1.0f) / std::max(1e-6f, layers_->coat.passed(w)));
}

Rgb DisneyBsdf::albedo_above_clear(const Vec3f& w) const {
  Rgb albedo = specular_albedo(w);
  if (!(nonmetal_ < 1)) return albedo;
  DisneySpecular bare = specular_;
  bare.f0 = base_color_ * (1 - nonmetal_), bare.f90 = Rgb(1 - nonmetal_), bare.film = {};
  const Rgb metal = albedo_of(bare, w) + several_of_metal_ * lost_among_facets(w);
  for (int c = 0; c < 3; ++c) albedo[c] = over(albedo[c] - metal[c], nonmetal_);
  return albedo;
}

// The walk of a thick body returns at most its base colour; thin bodies let light through besides, which is not theirs.
// What the coat's colour takes is left to nobody.
Rgb DisneyBsdf::room(const Vec3f& w) const {
  float room = 1;
  if (coated())
    room = over(room - max_component(albedo_of(layers_->coat.layer, layers_->coat.frame.to_local(w))),
                layers_->coat.passed(w));
  if (fibrous()) room = over(room - max_component(layers_->fibres.albedo(w)), layers_->fibres.passed(w.z));
  const float entry =
      dielectric_ * stays_ * DisneyDiffuse::lambert_albedo(w.z) * (coated() ? lambert_under_coat(layers_->coat) : 1);
  return Rgb(room - clear_) - entry_channels_ * walked_color_ * entry;
}

KeptShares DisneyBsdf::kept_along(const Vec3f& w) const {
  const Rgb base = base_albedo(w), specular = specular_albedo(w),
            left = is_transparent_ ? room(w) + albedo_above_clear(w) * clear_ : room(w);
  KeptShares kept;
  for (int c = 0; c < 3; ++c) {
    if (base[c] + specular[c] <= left[c]) continue;
    if (base[c] > 0) kept.base[c] = std::clamp((left[c] - specular[c]) / base[c], 0.0f, 1.0f);
    if (specular[c] > std::max(0.0f, left[c])) kept.specular[c] = std::max(0.0f, left[c]) / specular[c];
  }
  return kept;
}

}  // namespace alabaster
