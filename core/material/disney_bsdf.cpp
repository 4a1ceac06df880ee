#include "core/material/disney_bsdf.h"

namespace alabaster {
namespace {

constexpr size_t index(Lobe lobe) {
  return static_cast<size_t>(lobe);
}

/// 1 in the channels whose light enters the medium.
Rgb scattering_channels(const Rgb& scatter_distance) {
  return {scatter_distance.r > 0 ? 1.0f : 0.0f, scatter_distance.g > 0 ? 1.0f : 0.0f,
          scatter_distance.b > 0 ? 1.0f : 0.0f};
}

}  // namespace

DisneyBsdf::DisneyBsdf(const DisneyParameters& p, const Vec3f& wo)
    : wo_(wo), base_color_(p.base_color), specular_(DisneySpecular::from(p)) {
  if (!(wo.z > 0)) return;
  dielectric_ = 1 - p.metallic;
  entry_channels_ = scattering_channels(p.scatter_distance);
  const Rgb color = p.base_color * dielectric_;
  diffuse_ = {color * (Rgb(1.0f) - entry_channels_), color, p.roughness};
  sheen_.color = lerp(Rgb(1.0f), tint(p.base_color), p.sheen_tint) * (p.sheen * dielectric_);
  clearcoat_ = DisneyClearcoat::from(p.clearcoat, p.clearcoat_gloss);

  // Proportional to the estimated contribution. A walk also carries light straight through thin parts, whatever the
  // albedo: a dark medium is entered with a tenth of a white one's probability, not with none.
  const Rgb walked = subsurface_entry() * (p.base_color * 0.9f + Rgb(0.1f));
  float weight[kLobes];
  weight[index(Lobe::diffuse)] = choice_weight(diffuse_.albedo(wo));
  weight[index(Lobe::sheen)] = choice_weight(sheen_.albedo(wo));
  weight[index(Lobe::specular)] = choice_weight(specular_.albedo(wo));
  weight[index(Lobe::clearcoat)] = choice_weight(clearcoat_.albedo(wo));
  weight[index(Lobe::subsurface)] = choice_weight(walked);
  float total = 0;
  for (float w : weight) total += w;
  if (!(total > 0)) return;
  for (int i = 0; i < kLobes; ++i) probability_[i] = weight[i] / total;
}

Rgb DisneyBsdf::eval(const Vec3f& wi) const {
  if (!(wo_.z > 0 && wi.z > 0)) return Rgb(0.0f);
  Rgb f(0.0f);
  if (probability_[index(Lobe::diffuse)] > 0) f += diffuse_.eval(wo_, wi);
  if (probability_[index(Lobe::sheen)] > 0) f += sheen_.eval(wo_, wi);
  if (probability_[index(Lobe::specular)] > 0) f += specular_.eval(wo_, wi);
  if (probability_[index(Lobe::clearcoat)] > 0) f += clearcoat_.eval(wo_, wi);
  return f;
}

// Never above one: eval adds the same terms to something that is not negative, and rounding is monotonic.
Rgb DisneyBsdf::specular_share(const Vec3f& wi) const {
  const Rgb all = eval(wi);
  Rgb share(0.0f);
  if (is_black(all)) return share;
  if (probability_[index(Lobe::specular)] > 0) share += specular_.eval(wo_, wi);
  if (probability_[index(Lobe::clearcoat)] > 0) share += clearcoat_.eval(wo_, wi);
  for (int c = 0; c < 3; ++c) share[c] = all[c] > 0 ? share[c] / all[c] : 0;
  return share;
}

float DisneyBsdf::pdf(const Vec3f& wi) const {
  if (!(wo_.z > 0 && wi.z > 0)) return 0;
  // Diffuse and sheen are sampled alike.
  const float cosine = probability_[index(Lobe::diffuse)] + probability_[index(Lobe::sheen)];
  float pdf = cosine * pdf_cosine_hemisphere(wi);
  if (probability_[index(Lobe::specular)] > 0) pdf += probability_[index(Lobe::specular)] * specular_.pdf(wo_, wi);
  if (probability_[index(Lobe::clearcoat)] > 0) pdf += probability_[index(Lobe::clearcoat)] * clearcoat_.pdf(wo_, wi);
  return pdf;
}

Lobe DisneyBsdf::choose(float u) const {
  int chosen = 0;
  for (int i = 0; i < kLobes; ++i) {
    // The last lobe that has a probability takes what rounding leaves.
    if (probability_[i] > 0) chosen = i;
    if (u < probability_[i]) break;
    u -= probability_[i];
  }
  return static_cast<Lobe>(chosen);
}

std::optional<Vec3f> DisneyBsdf::sample_direction(Lobe lobe, const Vec2f& u) const {
  switch (lobe) {
    case Lobe::diffuse:
      return diffuse_.sample(wo_, u);
    case Lobe::sheen:
      return sheen_.sample(wo_, u);
    case Lobe::specular:
      return specular_.sample(wo_, u);
    case Lobe::clearcoat:
      return clearcoat_.sample(wo_, u);
    case Lobe::subsurface:
      break;
  }
  return std::nullopt;
}

std::optional<BsdfSample> DisneyBsdf::sample(float u_lobe, const Vec2f& u) const {
  BsdfSample sample;
  sample.lobe = choose(u_lobe);
  // No lobe at all: the first one is named and has no probability.
  if (!(probability_[index(sample.lobe)] > 0)) return std::nullopt;
  if (sample.lobe == Lobe::subsurface) {
    sample.f = subsurface_entry();
    sample.pdf = probability_[index(Lobe::subsurface)];
    return sample;
  }
  const std::optional<Vec3f> wi = sample_direction(sample.lobe, u);
  if (!wi) return std::nullopt;
  sample.wi = *wi;
  sample.f = eval(*wi);
  sample.pdf = pdf(*wi);
  if (!(sample.pdf > 0)) return std::nullopt;
  return sample;
}

Rgb DisneyBsdf::subsurface_entry() const {
  return entry_channels_ * (dielectric_ * diffuse_transmittance(wo_.z));
}

Rgb DisneyBsdf::albedo() const {
  if (!(wo_.z > 0)) return Rgb(0.0f);
  return clamp01(base_color_ * dielectric_ + schlick(specular_.f0, specular_.f90, wo_.z));
}

float eval_subsurface_exit(const Vec3f& wi) {
  return wi.z > 0 ? kInvPi * diffuse_transmittance(wi.z) : 0;
}

}  // namespace alabaster
