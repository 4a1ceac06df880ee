// The reflectance of a surface under a film as thin as waves of light are long (Belcour and Barla 2017, "A Practical
// Extension to Microfacet Theory for the Modeling of Varying Iridescence", as KHR_materials_iridescence has it): the
// Airy sum to the second order, with the spectral sensitivity of the eye as Gaussians in its Fourier space (appendix).
// Colours are those of Rec.709's primaries.
#pragma once

#include "core/color/rgb.h"
#include "core/material/disney_parameters.h"

namespace alabaster {

struct ThinFilm {
  float share = 0;  // of the surface; 0: no film
  float ior = 1.3f;
  float thickness = 400;  // nanometres

  /// One without thickness, or of the index of air, is none.
  static ThinFilm of(const DisneyParameters& p) {
    if (!(p.iridescence > 0 && p.iridescence_thickness > 0 && p.iridescence_ior > 1)) return {};
    return {p.iridescence, p.iridescence_ior, p.iridescence_thickness};
  }

  /// Reflectance for light that comes through air at this cosine; `f0`: the reflectance of what lies beneath, in air,
  /// seen head on. In [0,1] per channel. Without a film it is Schlick's, from f0 to 1.
  Rgb reflectance(float cosine, const Rgb& f0) const;
  /// The reflectance of a surface that reflects `bare` without the film: it changes by as much as Schlick's, from `f0`
  /// to `f90`.
  Rgb over(const Rgb& bare, float cosine, const Rgb& f0, float f90 = 1) const;
};

}  // namespace alabaster
