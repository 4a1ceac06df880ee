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

const char* lobe_name(Lobe lobe) {
  constexpr const char* kNames[] = {"diffuse",    "sheen",      "specular", "clearcoat",
                                    "subsurface", "dielectric", "straight", "diffuse transmission"};
  static_assert(std::size(kNames) == index(Lobe::count));
  return kNames[index(lobe)];
}

DisneyBsdf::DisneyBsdf(const DisneyParameters& p, const Vec3f& wo, EnergyModel energy)
    : wo_(wo),
      base_color_(p.base_color),
      walked_color_(p.base_color),
      specular_(DisneySpecular::from(p)),
      energy_(energy) {
  if (!(wo.z > 0)) return;
  nonmetal_ = 1 - p.metallic;
  dielectric_ = nonmetal_ * (1 - p.spec_trans);
  stays_ = 1 - 0.5f * p.diff_trans;
  if (!p.thin && p.subsurface_weight > 0) entry_channels_ = scattering_channels(p.scatter_distance);
  const Rgb color = p.base_color * (dielectric_ * stays_);
  diffuse_ = {color * (Rgb(1.0f) - entry_channels_), color, p.retro_roughness(), p.thin ? p.flatness : 0};
  if (p.is_mixed()) [[unlikely]]
    mix(p);
  if (p.has_dimming_layers()) [[unlikely]]
    layers_ = DisneyLayers::of(p);
  if (p.sheen > 0 && !fibrous()) sheen_.color = sheen_hue(p) * (p.sheen * dielectric_);
  clearcoat_ = DisneyClearcoat::from(p.clearcoat, p.clearcoat_gloss, p.least_roughness);
  if (p.least_roughness > 0) [[unlikely]]
    keep_albedos(p);

  if (is_bounded()) bound_energy(p);

  // Proportional to the estimated contribution. A walk also carries light straight through thin parts, even where the
  // albedo is zero: a dark medium is entered with a tenth of a white one's probability, not with none.
  set_probabilities(subsurface_entry() * (walked_color_ * 0.9f + Rgb(0.1f)));
}

void DisneyBsdf::mix(const DisneyParameters& p) {
  const float w = p.subsurface_weight, share = dielectric_ * stays_;
  walked_color_ = p.medium_albedo();
  base_color_ = p.mixed_color();
  const Rgb above = p.base_color * (1 - w), below = walked_color_ * w;
  diffuse_.lambert_color = (above + below * (Rgb(1.0f) - entry_channels_)) * share;
  diffuse_.retro_color = (above + below) * share;
  entry_channels_ *= w;
}

void DisneyBsdf::set_probabilities(const Rgb& walked) {
  float weight[kLobes] = {};
  const Rgb diffuse = diffuse_.albedo(wo_) * kept_.base + several_albedo_ * lost_, specular = specular_.albedo(wo_);
  const Rgb sheen = fibrous() ? layers_->fibres.albedo(wo_) : sheen_.albedo(wo_);
  weight[index(Lobe::diffuse)] = choice_weight(diffuse);
  weight[index(Lobe::sheen)] = choice_weight(sheen);
  weight[index(Lobe::specular)] = choice_weight(specular);
  weight[index(Lobe::clearcoat)] = choice_weight(coated() ? layers_->coat.albedo(wo_) : clearcoat_.albedo(wo_));
  weight[index(Lobe::subsurface)] = choice_weight(walked);
  if (layers_) [[unlikely]] {
    const Rgb once = coat_passage(), twice = once * once;
    weight[index(Lobe::diffuse)] = choice_weight(twice * diffuse);
    weight[index(Lobe::sheen)] = choice_weight(twice * sheen);
    weight[index(Lobe::specular)] = choice_weight(twice * specular);
    weight[index(Lobe::subsurface)] = choice_weight(once * walked);  // it has the way in
    weight[index(Lobe::diffuse)] *= passed_layers(wo_);
    weight[index(Lobe::specular)] *= std::sqrt(passed_layers(wo_));
    if (coated()) weight[index(Lobe::sheen)] *= layers_->coat.passed(wo_);
  }
  float total = 0;
  for (float w : weight) total += w;
  if (!(total > 0)) return;
  weight_ = total;
  for (int i = 0; i < kLobes; ++i) probability_[i] = chance_of(weight[i], total);
}

BsdfValue DisneyBsdf::evaluate(const Vec3f& wi, Rgb* specular) const {
  if (specular) *specular = Rgb(0.0f);
  if (!(wo_.z > 0)) return {};
  if (!layers_) [[likely]]
    return is_bounded() ? evaluate_below_coat<false, true>(wi, specular)
                        : evaluate_below_coat<false, false>(wi, specular);
  BsdfValue sum =
      is_bounded() ? evaluate_below_coat<true, true>(wi, specular) : evaluate_below_coat<true, false>(wi, specular);
  const Rgb passed = coat_passage() * coat_passage();
  sum.f_cos *= passed;
  if (specular) *specular *= passed;
  const float probability = probability_[index(Lobe::clearcoat)];
  if (!coated() || !(probability > 0)) return sum;
  const BsdfValue coat = layers_->coat.evaluate(wo_, wi);
  sum.f_cos += coat.f_cos;
  sum.pdf += probability * coat.pdf;
  if (specular) *specular += coat.f_cos;
  return sum;
}

template <bool kLayered, bool kBounded>
BsdfValue DisneyBsdf::evaluate_below_coat(const Vec3f& wi, Rgb* specular) const {
  if (!(wi.z > 0)) return {};
  const KeptShares kept = kBounded ? kept_towards(wi) : KeptShares();
  LobeValue sum;
  // Diffuse and Burley's sheen are sampled alike.
  const float diffuse = probability_[index(Lobe::diffuse)], sheen = probability_[index(Lobe::sheen)];
  const bool fibrous = kLayered && layers_->fibrous(), coated = kLayered && layers_->coated();
  const float below = fibrous ? layers_->fibres.over(wo_.z, wi.z) : 1;
  sum.pdf = (fibrous ? diffuse : diffuse + sheen) * pdf_cosine_hemisphere(wi);
  if (diffuse > 0) sum.f += diffuse_.evaluate(wo_, wi).f;
  if (!fibrous && sheen > 0) sum.f += sheen_.evaluate(wo_, wi).f;
  if (kBounded) sum.f *= kept.base;
  if (fibrous) {
    const LobeValue fibres = layers_->fibres.evaluate(wo_, wi);
    sum.f = sum.f * below + fibres.f;
    sum.pdf += sheen * fibres.pdf;
  }
  if (coated) sum.f *= layers_->coat.over_diffuse(wo_, wi);
  // The specular part is never above f, which adds the same terms to a sum that is not negative: rounding is monotonic.
  if (kBounded && lost_ > 0) {
    const Rgb seen = several_facets(wi) * kept.specular *
                     ((fibrous ? below : 1) * (coated ? layers_->coat.over_diffuse(wo_, wi) : 1));
    sum.f += seen;
    if (specular) *specular += seen;
  }
  const auto add = [&](Lobe lobe, const LobeValue& value) {
    sum.f += value.f;
    sum.pdf += probability_[index(lobe)] * value.pdf;
    if (specular) *specular += value.f;
  };
  if (probability_[index(Lobe::specular)] > 0) {
    LobeValue value = specular_.evaluate(wo_, wi);
    if (kBounded) value.f *= kept.specular;
    if (fibrous) value.f *= below;
    if (coated) value.f *= layers_->coat.over_specular(wo_, wi);
    add(Lobe::specular, value);
  }
  if (!coated && probability_[index(Lobe::clearcoat)] > 0) {
    LobeValue value = clearcoat_.evaluate(wo_, wi);
    if (kBounded) value.f *= kept.specular;
    add(Lobe::clearcoat, value);
  }
  if (specular) *specular *= wi.z;
  return {sum.f * wi.z, sum.pdf};
}

Lobe DisneyBsdf::choose(float u) const {
  int chosen = 0;
  for (int i = 0; i < kLobes; ++i) {
    // The last lobe that has a probability takes the rest that rounding leaves.
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
      return fibrous() ? layers_->fibres.sample(wo_, u) : sheen_.sample(wo_, u);
    case Lobe::specular:
      return specular_.sample(wo_, u);
    case Lobe::clearcoat:
      return coated() ? layers_->coat.sample(wo_, u) : clearcoat_.sample(wo_, u);
    default:
      break;
  }
  return std::nullopt;
}

std::optional<BsdfSample> DisneyBsdf::sample(float u_lobe, const Vec2f& u, Rgb* specular) const {
  BsdfSample sample;
  sample.lobe = choose(u_lobe);
  // Without any lobe choose() names the first, which has no probability.
  if (!(probability_[index(sample.lobe)] > 0)) return std::nullopt;
  if (sample.lobe == Lobe::subsurface) {
    sample.f_cos = subsurface_entry();
    sample.pdf = probability_[index(Lobe::subsurface)];
    return sample;
  }
  const std::optional<Vec3f> wi = sample_direction(sample.lobe, u);
  if (!wi) return std::nullopt;
  sample.wi = *wi;
  const BsdfValue value = evaluate(*wi, specular);
  if (!(value.pdf > 0)) return std::nullopt;
  sample.f_cos = value.f_cos;
  sample.pdf = value.pdf;
  return sample;
}

Rgb DisneyBsdf::subsurface_entry() const {
  const Rgb entry = entry_channels_ * (dielectric_ * stays_ * diffuse_transmittance(wo_.z) * passed_layers(wo_));
  return layers_ ? entry * coat_passage() : entry;
}

float DisneyBsdf::exit_f_cos(const Vec3f& wi) const {
  return subsurface_exit_f_cos(wi.z) * (layers_ ? layers_->leaving(wi, layers_->entered(wo_)) : 1);
}

Rgb DisneyBsdf::albedo() const {
  if (!(wo_.z > 0)) return Rgb(0.0f);
  const Rgb passage = coat_passage();
  return clamp01(passage * passage * (base_color_ * nonmetal_ + schlick(specular_.f0, specular_.f90, wo_.z)));
}

}  // namespace alabaster
