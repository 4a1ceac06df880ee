// The Disney BSDF (Burley 2015) at one point, with its Lambertian term taken out where the medium scatters.
//
// Conventions (Veach 1997, 3.7.5): wo to the viewer, wi to the light, both leave the surface and are unit; local frame
// with z = ns and x along the tangent of anisotropy; values have the cosine |wi.z|; pdf per solid angle. A coat has a
// normal of its own (disney_coat.h), by which it counts light, and may reflect to wi.z <= 0.
//
// f = (1-metallic) (1-specTrans) [ diffuse + sheen ] + specular + clearcoat, the diffuse part being
//   (C/pi)(1-.5F_L)(1-.5F_V)  +  (C/pi) R_R (F_L + F_V + F_L F_V (R_R-1)),  R_R = 2 roughness cos^2(theta_d).
// In each channel with scatter_distance > 0 the first term is absent from evaluate and sample: it is the subsurface
// entry lobe, which the integrator walks. In a channel with scatter_distance = 0 it is exactly the 2015 diffuse.
// With a weight w and an albedo A of the medium C is (1-w) C + w A, and the lobe is the part w of the first term.
// This is all that stays on the viewer's side but for the clear share of the base: disney_transmissive_bsdf.h.
#pragma once

#include <optional>

#include "core/material/disney_clearcoat.h"
#include "core/material/disney_diffuse.h"
#include "core/material/disney_layers.h"
#include "core/material/disney_parameters.h"
#include "core/material/disney_sheen.h"
#include "core/material/disney_specular.h"
#include "core/material/energy_model.h"
#include "core/math/vector.h"

namespace alabaster {

enum class Lobe {
  diffuse,
  sheen,
  specular,
  clearcoat,
  subsurface,
  // The others belong to DisneyTransmissiveBsdf alone.
  dielectric,            // reflected or refracted by a clear boundary
  straight,              // passed it in the same direction, by a discrete choice
  diffuse_transmission,  // scattered to the other side
  count
};
const char* lobe_name(Lobe lobe);

struct BsdfSample {
  Lobe lobe = Lobe::diffuse;
  Vec3f wi{0, 0, 1};  // not set for Lobe::subsurface
  Rgb f_cos{0.0f};    // all local lobes' for wi; for Lobe::subsurface the entry weight per channel (see below), for
                      // Lobe::straight what passes
  float pdf = 0;  // of all local lobes together, including the probability not to choose subsurface or straight; for
                  // those the (discrete) probability of that choice
  /// The reciprocal of the least densities is not finite.
  Rgb weight() const { return {f_cos.r / pdf, f_cos.g / pdf, f_cos.b / pdf}; }
};

class DisneyBsdf {
 public:
  /// `parameters` must lie in the ranges of material_parameters(). wo.z <= 0 gives a BSDF that is zero everywhere.
  DisneyBsdf(const DisneyParameters& parameters, const Vec3f& wo, EnergyModel energy = EnergyModel::burley2015);

  /// All local lobes together. The pdf is the sum of probability times pdf over them: it integrates to 1 -
  /// P(subsurface) less the share that specular samples lose below the horizon. `specular`, unless null, receives the
  /// specular and clearcoat lobes' part of f cos, which is never above it; the rest is diffuse and sheen.
  BsdfValue evaluate(const Vec3f& wi, Rgb* specular = nullptr) const;
  /// `u_lobe` chooses the lobe, `u` the direction. Empty: no sample (absorbed). f_cos, pdf and `specular` are those of
  /// evaluate(wi); `specular` is left alone for Lobe::subsurface.
  std::optional<BsdfSample> sample(float u_lobe, const Vec2f& u, Rgb* specular = nullptr) const;

  /// Entry weight of the walk per channel: w (1-metallic)(1-specTrans)(1-diffTrans/2)(1-.5F_V) where scatter_distance >
  /// 0, else 0. The medium's colour is in the walk's throughput, never here; a coat's is.
  Rgb subsurface_entry() const;

  /// subsurface_exit_f_cos() where the light entered, under the layers, but for coat_passage().
  float exit_f_cos(const Vec3f& wi) const;

  /// The estimate of all that it reflects and lets enter by which lobes are chosen; 0 if it does neither.
  float weight() const { return weight_; }

  /// False where evaluate() has f = 0 for any material: below the horizon of all lobes.
  bool reaches(const Vec3f& wi) const { return wi.z > 0 || (coated() && layers_->coat.reaches(wi)); }

  /// Null: none.
  const DisneyLayers* layers() const { return layers_ ? &*layers_ : nullptr; }
  /// The share of light that coat and fibres let in or out along `w`, but for the coat's colour.
  float passed_layers(const Vec3f& w) const { return layers_ ? layers_->passed(w) : 1; }
  /// DisneyCoat::passage.
  Rgb coat_passage() const { return layers_ ? layers_->coat.passage : Rgb(1.0f); }

  /// The shares that are kept along `w`, w.z > 0. Not for burley2015, which keeps all.
  KeptShares kept(const Vec3f& w) const { return w.z >= safe_cosine_ ? KeptShares() : kept_along(w); }
  /// Between wo and wi.
  KeptShares kept_towards(const Vec3f& wi) const {
    return wi.z >= safe_cosine_ ? kept_ : lesser(kept_, kept_along(wi));
  }
  bool is_bounded() const { return energy_ != EnergyModel::burley2015; }

  /// What lies above a transparent surface's clear share: the dielectric's part of specular_albedo(), per its share.
  Rgb albedo_above_clear(const Vec3f& w) const;

  /// Directional albedo estimate for the denoising AOV: diffuse colour, which a clear base has too, plus specular
  /// reflectance at wo.
  Rgb albedo() const;

 private:
  static constexpr int kLobes = static_cast<int>(Lobe::subsurface) + 1;  // the first of enum Lobe

  bool fibrous() const { return layers_ && layers_->fibrous(); }
  bool coated() const { return layers_ && layers_->coated(); }

  // disney_energy.cpp
  void keep_albedos(const DisneyParameters& parameters);
  void bound_energy(const DisneyParameters& parameters);
  void add_several_facets(const DisneyParameters& p);
  /// Directions of at least this cosine keep all shares, by a bound that costs less than the albedos themselves; more
  /// than 1: it does not tell.
  float least_safe_cosine() const;
  KeptShares kept_along(const Vec3f& w) const;
  /// What specular and clearcoat reflect of light along `w`, w.z > 0, per what layers let pass.
  Rgb specular_albedo(const Vec3f& w) const;
  Rgb base_albedo(const Vec3f& w) const;
  /// The share that is left to the base and the specular lobes by the others: the walk, a clear boundary, coat and
  /// fibres.
  Rgb room(const Vec3f& w) const;
  /// The share of white light along `w` that facets take from others.
  float lost_among_facets(const Vec3f& w) const;
  /// The lobe of light that several facets reflect one after the other.
  Rgb several_facets(const Vec3f& wi) const;

  /// The diffuse base and the walk of a mixture.
  void mix(const DisneyParameters& p);
  template <bool kLayered, bool kBounded>
  BsdfValue evaluate_below_coat(const Vec3f& wi, Rgb* specular) const;
  /// Divides the samples among the lobes. `walked`: the light that subsurface is expected to carry.
  void set_probabilities(const Rgb& walked);
  Lobe choose(float u) const;
  std::optional<Vec3f> sample_direction(Lobe lobe, const Vec2f& u) const;

  Vec3f wo_;
  Rgb base_color_{0.0f};
  Rgb walked_color_{0.0f};    // the medium's albedo
  float nonmetal_ = 0;        // 1 - metallic
  float dielectric_ = 0;      // the opaque share of the dielectric base
  float stays_ = 1;           // the share of diffuse light that does not leave on the other side
  Rgb entry_channels_{0.0f};  // the walk's weight, 0 in channels that do not scatter
  DisneyDiffuse diffuse_;
  DisneySheen sheen_;
  DisneySpecular specular_;
  DisneyClearcoat clearcoat_;
  std::optional<DisneyLayers> layers_;

  EnergyModel energy_;
  KeptShares kept_;  // along wo
  float safe_cosine_ = 2;
  float clear_ = 0;              // the share of a clear boundary, whose lobe is not here
  bool is_transparent_ = false;  // it lies below specular
  Rgb beyond_{0.0f};             // the diffuse albedo of the other side, whose lobe is not here
  Rgb several_{0.0f};         // f of several_facets() per lost_among_facets() of both directions; black: there is none
  Rgb several_albedo_{0.0f};  // the directional albedo of several_facets() per lost_among_facets()
  Rgb several_of_metal_{0.0f};  // the metal's part of it
  float lost_ = 0;              // along wo
  // Indexed by Lobe; sum to one, or are all zero. Zero only for a lobe that is zero, or next to it, in every direction.
  float probability_[kLobes] = {};
  float weight_ = 0;
};

/// f cos of the exit lobe of a walk: f = (1/pi)(1-.5F_L), a Lambertian lobe about the exit normal (Chiang, Kutz, Burley
/// 2016, section 4). Layers there have a factor, DisneyLayers::leaving(). Sampling is cosine_hemisphere.
inline float subsurface_exit_f_cos(float cosine) {
  return cosine > 0 ? kInvPi * diffuse_transmittance(cosine) * cosine : 0;
}

}  // namespace alabaster
