// The exact solution of an index-matched half-space of isotropic scatterers, for comparison with the albedo inversions.
#pragma once

namespace alabaster::testing {

/// Chandrasekhar H-function for isotropic scattering, mu in [0,1], by the closed form
/// ln H = -(mu/pi) Int_0^{pi/2} ln(1 - alpha t cot t) / (cos^2 t + mu^2 sin^2 t) dt.
double chandrasekhar_h(double mu, double one_minus_alpha);

/// The albedo that a given 1 - alpha yields under cosine entry (Chandrasekhar 1960: A = 1 - 2 sqrt(1-alpha) Int_0^1 mu
/// H(mu) dmu).
double half_space_albedo(double one_minus_alpha);

}  // namespace alabaster::testing
