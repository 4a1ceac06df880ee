// The reflectance of a surface under a film as thin as waves of light are long (Belcour and Barla 2017, "A Practical
// Extension to Microfacet Theory for the Modeling of Varying Iridescence", as KHR_materials_iridescence has it): the
// Airy sum to the second order, with the spectral sensitivity of the eye as Gaussians in its Fourier space (appendix).
// Colours are those of Rec.709's primaries.
#pragma once

#include "core/color/rgb.h"

namespace alabaster {

struct ThinFilm {
  float share = 0;  // of the surface; 0: no film
  float ior = 1.3f;
  float thickness = 400;  // nanometres

  /// Reflectance for light that comes through air at this cosine; `f0`: the reflectance of what lies beneath, in air,
  /// seen head on. In [0,1] per channel.
  Rgb reflectance(float cosine, const Rgb& f0) const;
};

}  // namespace alabaster
