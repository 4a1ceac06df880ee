// The Disney BSDF of a surface that transmits light (Burley 2015, section 5): DisneyBsdf and two more lobes.
//
// - A clear boundary of weight (1-metallic) specTrans: DisneyDielectric for a solid, DisneyThinDielectric for a sheet.
// - A cosine lobe on the other side of weight (1-metallic) (1-specTrans) diffTrans/2 and colour diffTransColor.
//
// The clear boundary of a solid tints what passes by the square root of baseColor, once on the way in and once on the
// way out; that of a sheet by baseColor. Diffuse, sheen and subsurface entry have the share (1-metallic)(1-specTrans).
// Directions as in disney_bsdf.h, but wi may be on either side: |wi.z| is its cosine. Light that crosses into a medium
// of index eta has its radiance over eta^2 (disney_dielectric.h).
//
// Coat, fibres and film lie on both sides of a sheet and on the outer side of a solid. Light that passes is dimmed by
// those of both sides: by DisneyLayers' factors where both have some, else by the share that the layers of the one side
// let through. A pair of directions has one factor, so f stays reciprocal. Light that the layers of a solid do not let
// out comes back to its inside. A coat's colour is taken once through the wall of a solid, twice through a sheet.
//
// A transparent surface (DisneyParameters::is_transparent) has no boundary of its own: its clear share passes straight
// on what DisneyBsdf's specular lobes leave.
//
// The clear boundary does not get back the light that rough facets lose between them, whatever the energy model.
#pragma once

#include "core/material/disney_bsdf.h"
#include "core/material/disney_dielectric.h"
#include "core/material/disney_thin_dielectric.h"

namespace alabaster {

/// The side of a surface that is seen, and what lies beyond it.
struct InterfaceSide {
  float eta = 1.5f;     // index of the far side over that of the near side; of a sheet: its own over that around it
  bool inside = false;  // seen from the interior of a solid: coat, sheen and film lie on the other side
  bool open = false;    // of a mesh that is not closed: they lie on both sides
};

class DisneyTransmissiveBsdf {
 public:
  DisneyTransmissiveBsdf(const DisneyParameters& parameters, const Vec3f& wo, const InterfaceSide& side,
                         EnergyModel energy = EnergyModel::burley2015);

  /// As DisneyBsdf's. `specular` includes the clear boundary.
  BsdfValue evaluate(const Vec3f& wi, Rgb* specular = nullptr) const;
  std::optional<BsdfSample> sample(float u_lobe, const Vec2f& u, Rgb* specular = nullptr) const;

  /// True if f for `wi` is reflected light, which stays on wo's side.
  bool reflects_to(const Vec3f& wi) const { return near_.reaches(wi); }

  /// What passes straight on, by Lobe::straight. Black: that is no lobe here.
  Rgb straight() const;

  /// False if all light that passes goes straight on: evaluate() is zero on the other side.
  bool scatters_beyond() const;

 private:
  /// The layers on which sides of the surface, as seen from wo.
  enum class Layered { near, far, both };
  DisneyTransmissiveBsdf(const DisneyParameters& parameters, const Vec3f& wo, const InterfaceSide& side,
                         Layered layered, EnergyModel energy);

  using LayerFactor = float (DisneyLayers::*)(const Vec3f&, const Vec3f&) const;
  /// The share that the layers leave of light that a lobe below them sends from wi to wo; `over`: DisneyLayers' factor
  /// for it.
  Rgb left_by_layers(const Vec3f& wi, LayerFactor over) const;
  /// The share that is kept of light that is scattered from wi, on the far side, to wo.
  Rgb kept_beyond(const Vec3f& wi) const;

  /// Probability that the diffuse lobe beyond is sampled as the light that comes back.
  float chance_of_back() const;

  void keep_boundary_albedo(const DisneyParameters& parameters, float eta);

  /// f(lobe) of the clear boundary: the solid one or the sheet.
  template <class F>
  auto at_boundary(const F& f) const {
    return thin_ ? f(sheet_) : f(solid_);
  }

  Vec3f wo_;
  bool thin_;
  Layered layered_;
  DisneyBsdf near_;
  std::optional<DisneyBsdf> other_side_;  // where energy is bounded there by other lobes
  DisneyDielectric solid_;
  DisneyThinDielectric sheet_;
  float reflects_ = 0, passes_ = 0;  // shares of the clear boundary's two lobes: alike but for widened sheets
  Rgb diffuse_beyond_{0.0f};         // colour of the diffuse light on the other side
  Rgb diffuse_back_{0.0f};           // colour of the part that the layers on the other side do not let out
  // Probabilities of the three parts; sum to one, or are all zero.
  float p_near_ = 0, p_clear_ = 0, p_beyond_ = 0;
};

}  // namespace alabaster
