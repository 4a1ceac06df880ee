// A second Disney BRDF of 2012, written from the published formulas in angles and in double precision, without code of
// core/material. Tests compare the lobes with it. Burley 2012, "Physically Based Shading at Disney", sections 5.3 to
// 5.7 and appendix B; masking without the roughness remapping of 2012 (Burley 2015, section 2).
#pragma once

#include <array>

#include "core/math/vector.h"

namespace alabaster::testing {

struct ReferenceParameters {
  std::array<double, 3> base_color{0.8, 0.8, 0.8};
  double metallic = 0, roughness = 0.5, anisotropic = 0, specular_tint = 0, ior = 1.5;
  double sheen = 0, sheen_tint = 0.5, clearcoat = 0, clearcoat_gloss = 1;
};

/// f without cosine, each term by itself; wo, wi unit and above the horizon, not opposite.
struct ReferenceTerms {
  std::array<double, 3> diffuse, sheen, specular;  // the first two include 1 - metallic
  double clearcoat;
};

ReferenceTerms disney_reference_2012(const ReferenceParameters& p, const Vec3d& wo, const Vec3d& wi);

}  // namespace alabaster::testing
