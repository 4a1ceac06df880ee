// Directional albedos of the lobes, the share of light from one direction that a lobe reflects in all: Int f wi.z dwi.
// Tables made at the first call, in a tenth of a second or less, and for each anisotropy. Their errors are stated and
// tested. Any thread.
#pragma once

#include "core/material/microfacet.h"

namespace alabaster {

/// A white GGX lobe, and what is left of it where Schlick's (1 - cos_d)^5 weighs the facets: the lobe of f0 and f90
/// reflects f0 (white - schlick) + f90 schlick.
struct GgxAlbedo {
  float white, schlick;
};
/// Bounds of GgxAlbedo::schlick, clearcoat_albedo() and sheen_albedo() for all facets where the cosine is at least so
/// much.
struct SteepAlbedos {
  float cosine, schlick, clearcoat, sheen;
};
inline constexpr SteepAlbedos kSteepAlbedos[] = {
    {0.1f, 0.61f, 0.048f, 0.067f}, {0.25f, 0.25f, 0.041f, 0.042f}, {0.5f, 0.036f, 0.016f, 0.016f}};
/// wo.z > 0. Within 1e-3 where cosine and alpha are above 0.01, of anisotropic facets 3e-3.
GgxAlbedo ggx_albedo(const Vec3f& wo, const Ggx& ggx);
/// The cosine-weighted mean of the white albedo over the hemisphere.
float mean_ggx_albedo(const Ggx& ggx);

/// The shares of white light that the facets of a clear boundary reflect and let through (DisneyDielectric): together
/// 1, less the share that they shadow.
struct DielectricAlbedo {
  float reflected, passed;
};
/// cosine > 0; `eta`: the index of the far side over that of the near side, in [1/4, 4]. Within 0.02, and within 0.06
/// at angles of total reflection.
DielectricAlbedo dielectric_albedo(float cosine, float alpha, float eta);

/// Burley's clearcoat of strength 1, within 1e-3.
float clearcoat_albedo(float cosine, float gtr1_alpha);
/// Burley's sheen of colour 1, within 1e-4.
float sheen_albedo(float cosine);
/// DisneyDiffuse::flat() of white, within 5e-3.
float flat_albedo(float cosine, float roughness);

}  // namespace alabaster
