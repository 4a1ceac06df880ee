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
// The clear boundary does not get back the light that rough facets lose between them, whatever the energy model.
#pragma once

#include "core/material/disney_bsdf.h"
#include "core/material/disney_dielectric.h"
#include "core/material/disney_thin_dielectric.h"

namespace alabaster {

/// The side of a surface that is seen, and what lies beyond it.
struct BoundarySide {
  float eta = 1.5f;     // index of the far side over that of the near side; of a sheet: its own over that around it
  bool inside = false;  // seen from the interior of a solid: coat, sheen and film lie on the other side
};

class DisneyTransmissiveBsdf {
 public:
  DisneyTransmissiveBsdf(const DisneyParameters& parameters, const Vec3f& wo, const BoundarySide& side,
                         EnergyModel energy = EnergyModel::burley2015);

  /// As DisneyBsdf's. `specular` includes the clear boundary.
  BsdfValue evaluate(const Vec3f& wi, Rgb* specular = nullptr) const;
  std::optional<BsdfSample> sample(float u_lobe, const Vec2f& u, Rgb* specular = nullptr) const;

  /// False if all light that passes goes straight on: evaluate() is zero on the other side.
  bool scatters_beyond() const;

 private:
  DisneyTransmissiveBsdf(const Vec3f& wo, const DisneyParameters& parameters, float eta, EnergyModel energy);

  void keep_boundary_albedo(const DisneyParameters& parameters, float eta);

  /// f(lobe) of the clear boundary: the solid one or the sheet.
  template <class F>
  auto at_boundary(const F& f) const {
    return thin_ ? f(sheet_) : f(solid_);
  }

  Vec3f wo_;
  bool thin_;
  DisneyBsdf near_;
  DisneyDielectric solid_;
  DisneyThinDielectric sheet_;
  float reflects_ = 0, passes_ = 0;  // shares of the clear boundary's two lobes: alike but for widened sheets
  Rgb diffuse_beyond_{0.0f};         // colour of the diffuse light on the other side
  // Probabilities of the three parts; sum to one, or are all zero.
  float p_near_ = 0, p_clear_ = 0, p_beyond_ = 0;
};

}  // namespace alabaster
