#include "core/material/disney_transmissive_bsdf.h"

#include "core/material/directional_albedo.h"

namespace alabaster {
namespace {

Rgb square_root(const Rgb& c) {
  return {std::sqrt(c.r), std::sqrt(c.g), std::sqrt(c.b)};
}

DisneyParameters without_layers(DisneyParameters p) {
  p.clearcoat = p.coat = p.sheen = p.iridescence = 0;
  return p;
}

bool has_layers(const DisneyParameters& p) {
  return p.clearcoat > 0 || p.coat > 0 || p.sheen > 0 || p.iridescence > 0;
}

/// u in [0, share) spread over [0, 1).
float spread(float u, float share) {
  return std::min(u / share, kOneMinusEpsilon);
}

}  // namespace

DisneyTransmissiveBsdf::DisneyTransmissiveBsdf(const DisneyParameters& p, const Vec3f& wo, const InterfaceSide& side,
                                               EnergyModel energy)
    : DisneyTransmissiveBsdf(p, wo, side,
                             p.thin || side.open ? Layered::both
                             : side.inside       ? Layered::far
                                                 : Layered::near,
                             energy) {}

DisneyTransmissiveBsdf::DisneyTransmissiveBsdf(const DisneyParameters& p, const Vec3f& wo, const InterfaceSide& side,
                                               Layered layered, EnergyModel energy)
    : wo_(wo), thin_(p.thin), layered_(layered), near_(layered == Layered::far ? without_layers(p) : p, wo, energy) {
  if (!(wo.z > 0)) return;
  const float dielectric = 1 - p.metallic;
  const float share = dielectric * p.spec_trans;
  reflects_ = passes_ = share;
  diffuse_beyond_ = p.diff_trans_color * (dielectric * (1 - p.spec_trans) * 0.5f * p.diff_trans);
  if (layered == Layered::far && !is_black(diffuse_beyond_))
    if (const auto beyond = DisneyLayers::of(p)) diffuse_back_ = diffuse_beyond_ * beyond->mean_held_back();
  if (layered != Layered::both && near_.is_bounded() && !is_black(diffuse_beyond_) && has_layers(p))
    other_side_.emplace(layered == Layered::far ? p : without_layers(p), wo, energy);
  const Ggx ggx = disney_ggx(p.specular_roughness(), p.anisotropic);
  if (p.is_transparent()) {
    const Rgb reflected = near_.albedo_above_clear(wo);
    const Rgb left(std::max(1 - reflected.r, 0.0f), std::max(1 - reflected.g, 0.0f), std::max(1 - reflected.b, 0.0f));
    constexpr Ggx kSmooth{kMinAlpha, kMinAlpha};
    sheet_ = {{1, Rgb(0.0f), left}, kSmooth, kSmooth};
  } else if (thin_) {
    const float through = DisneyThinDielectric::roughness_through(p.roughness, p.ior);
    sheet_ = {DielectricBoundary::from(p, side.eta, p.base_color), ggx, disney_ggx(through, p.anisotropic)};
    sheet_.boundary.sheet = true;
  } else {
    // The colour of a cloudy body is that of its medium, unless that has its own.
    const Rgb tint = p.scatters() && !p.has_own_albedo() ? Rgb(1.0f) : square_root(p.base_color);
    solid_ = {DielectricBoundary::from(p, side.eta, tint, side.inside), ggx};
    if (layered == Layered::far) solid_.boundary.layers_beyond = DisneyLayers::of(p);
  }
  if (p.is_widened() && share > 0 && !p.is_transparent()) [[unlikely]]
    keep_boundary_albedo(p, side.eta);
  const Rgb color = near_.coat_passage(),
            boundary = color * at_boundary([&](const auto&lobe) { return lobe.albedo(wo); });
  const float passed = near_.passed_layers(wo), near = near_.weight(), clear = passed * share * choice_weight(boundary),
              beyond = passed * choice_weight(color * (diffuse_beyond_ + diffuse_back_)), total = near + clear + beyond;
  if (!(total > 0)) return;
  p_near_ = chance_of(near, total);
  p_beyond_ = chance_of(beyond, total);
  p_clear_ = p_beyond_ > 0 ? chance_of(clear, total) : 1 - p_near_;
}

Rgb DisneyTransmissiveBsdf::left_by_layers(const Vec3f& wi, LayerFactor over) const {
  const Vec3f w = wi.z > 0 ? wi : -wi;
  if (const DisneyLayers* const near = near_.layers()) {
    const Rgb& passage = near->coat.passage;
    if (wi.z > 0 || layered_ == Layered::both) return passage * passage * (near->*over)(wo_, w);
    return passage * near->passed(wo_);
  }
  const auto& beyond = solid_.boundary.layers_beyond;
  return beyond && wi.z < 0 ? beyond->coat.passage * beyond->passed(w) : Rgb(1.0f);
}

Rgb DisneyTransmissiveBsdf::kept_beyond(const Vec3f& wi) const {
  return (other_side_ ? lesser(near_.kept(wo_), other_side_->kept(-wi)) : near_.kept_towards(-wi)).base;
}

// White light along wo leaves a solid's boundary with the share that facets of the material's own roughness give it,
// both ways together: to keep each way's would trap light inside, where own facets reflect totally and widened ones
// send light that entered by other angles. A sheet's way through is not widened.
void DisneyTransmissiveBsdf::keep_boundary_albedo(const DisneyParameters& p, float eta) {
  if (p.iridescence > 0) return;  // the colours of a film change with the angle
  const auto albedo = [&](float roughness) {
    const Ggx ggx = disney_ggx(roughness, p.anisotropic);
    return dielectric_albedo(wo_.z, std::sqrt(ggx.alpha_x * ggx.alpha_y), eta);
  };
  const DielectricAlbedo own = albedo(p.roughness), widened = albedo(p.least_roughness);
  if (!(widened.reflected > 0)) return;
  if (thin_) {
    const auto both_faces = [c = choice_weight(p.base_color)](const DielectricAlbedo& face) {
      return face.reflected * (1 + c * face.passed / (2 * face.reflected + face.passed));
    };
    reflects_ *= both_faces(own) / both_faces(widened);
  } else {
    const float kept = (own.reflected + own.passed) / (widened.reflected + widened.passed);
    reflects_ *= kept, passes_ *= kept;
  }
}

float DisneyTransmissiveBsdf::chance_of_back() const {
  if (is_black(diffuse_back_)) return 0;
  const float back = choice_weight(diffuse_back_);
  return back / (choice_weight(diffuse_beyond_) + back);
}

bool DisneyTransmissiveBsdf::scatters_beyond() const {
  return p_beyond_ > 0 || (p_clear_ > 0 && !at_boundary([](const auto& lobe) { return lobe.is_straight(); }));
}

BsdfValue DisneyTransmissiveBsdf::evaluate(const Vec3f& wi, Rgb* specular) const {
  if (specular) *specular = Rgb(0.0f);
  if (!(wo_.z > 0) || wi.z == 0) return {};
  BsdfValue sum;
  if (p_near_ > 0) {
    sum = near_.evaluate(wi, specular);
    sum.pdf *= p_near_;
  }
  const float cosine = std::abs(wi.z);
  // Below the base's horizon and above the surface only a coat reflects; transmitted light does not leave there.
  const float passes = wi.z < 0 && near_.reaches(wi) ? 0 : 1;
  const float back = chance_of_back();
  if (wi.z < 0 && p_beyond_ > 0) {
    Rgb beyond = diffuse_beyond_ * (left_by_layers(wi, &DisneyLayers::over_diffuse) * kInvPi);
    if (near_.is_bounded()) beyond *= kept_beyond(wi);
    sum.f_cos += beyond * (passes * cosine);
    sum.pdf += p_beyond_ * (1 - back) * cosine * kInvPi;
  }
  if (wi.z > 0 && back > 0) [[unlikely]] {
    sum.f_cos += diffuse_back_ * (kInvPi * cosine) * (near_.is_bounded() ? near_.kept_towards(wi).base : Rgb(1.0f));
    sum.pdf += p_beyond_ * back * cosine * kInvPi;
  }
  if (p_clear_ > 0) {
    const LobeValue value = at_boundary([&](const auto& lobe) { return lobe.evaluate(wo_, wi); });
    const Rgb share = left_by_layers(wi, &DisneyLayers::over_clear) * (wi.z > 0 ? reflects_ : passes_ * passes);
    const Rgb clear = value.f * (share * cosine);
    sum.f_cos += clear;
    sum.pdf += value.pdf * p_clear_;
    if (specular) *specular += clear;
  }
  return sum;
}

Rgb DisneyTransmissiveBsdf::straight() const {
  if (!(p_clear_ > 0) || !at_boundary([](const auto& lobe) { return lobe.is_straight(); })) return Rgb(0.0f);
  const Rgb passed = at_boundary([&](const auto& lobe) {
    return lobe.boundary.passed_straight(wo_.z, std::max(lobe.ggx.alpha_x, lobe.ggx.alpha_y));
  });
  return passed * (left_by_layers(-wo_, &DisneyLayers::over_clear) * passes_);
}

std::optional<BsdfSample> DisneyTransmissiveBsdf::sample(float u_lobe, const Vec2f& u, Rgb* specular) const {
  BsdfSample sample;
  std::optional<Vec3f> wi;
  if (u_lobe < p_near_) {
    const auto near = near_.sample(spread(u_lobe, p_near_), u);
    if (!near) return std::nullopt;
    sample = *near;
    if (sample.lobe == Lobe::subsurface) {
      sample.pdf *= p_near_;
      return sample;
    }
    wi = sample.wi;
  } else if (u_lobe - p_near_ < p_clear_) {
    const float u_choice = spread(u_lobe - p_near_, p_clear_);
    sample.lobe = Lobe::dielectric;
    const float straight = at_boundary([&](const auto& lobe) { return lobe.chance_of_straight(wo_); });
    if (u_choice < straight) return BsdfSample{Lobe::straight, -wo_, this->straight(), p_clear_ * straight};
    wi = at_boundary([&](const auto& lobe) { return lobe.sample(wo_, u_choice, u); });
  } else if (p_beyond_ > 0) {
    sample.lobe = Lobe::diffuse_transmission;
    const Vec3f up = sample_cosine_hemisphere(u);
    const bool back = spread(std::max(0.0f, u_lobe - p_near_ - p_clear_), p_beyond_) < chance_of_back();
    wi = {up.x, up.y, back ? up.z : -up.z};
  }
  if (!wi) return std::nullopt;
  const BsdfValue value = evaluate(*wi, specular);
  if (!(value.pdf > 0)) return std::nullopt;
  return BsdfSample{sample.lobe, *wi, value.f_cos, value.pdf};
}

}  // namespace alabaster
