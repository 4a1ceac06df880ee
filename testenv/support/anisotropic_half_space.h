// The albedo of a half-space of Henyey-Greenstein scatterers, by a deterministic method other than that of
// testenv/walks/fit_anisotropic_inversion.py. Inversion and walks are compared with it.
#pragma once

namespace alabaster::testing {

/// Index-matched, entered through a cosine lobe, all exits counted. Invariant embedding (Ambartsumian 1943;
/// Chandrasekhar 1960, chapter IV): adding a thin layer to a half-space does not change its reflection, which gives a
/// quadratic equation for it, solved by iteration over the number of collisions on Gauss-Legendre directions. Error
/// below 1e-7 for |g| <= 0.9 and one_minus_alpha >= 1e-5; the number of steps grows as 1 / sqrt(one_minus_alpha).
double anisotropic_half_space_albedo(double one_minus_alpha, double g);

}  // namespace alabaster::testing
