// Exact facts of a half-space of isotropic scatterers below a plane where the index does not change.
#pragma once

namespace alabaster {

/// The probability that a particle leaves again which scatters isotropically (already counted) at `optical_depth` below
/// the plane: by reciprocity the mean intensity there under radiance 1 from all sides. `x`: 1/nu0 of the medium
/// (dwivedi.h). Within 6e-5 of the theory, 2e-4 below depth 3e-4, and 3e-6 in the mean over depths. The first call in a
/// process makes a table, which takes a few milliseconds.
///
/// The Laplace transform of that intensity J is known: Int alpha J(t) exp(-t/mu) dt/mu = 1 - sqrt(1-alpha) H(mu), the
/// directional albedo (Chandrasekhar 1960, section 38). Inverted along the cut where H(z) H(-z) = 1/Lambda(z) jumps,
///   J(t) = R exp(-x t) + s Int_0^1 w(nu) exp(-t/nu) dnu,   w = 1 / (2 H(nu) (lambda^2 + (pi alpha nu / 2)^2)),
/// lambda = 1 - alpha nu atanh(nu), s = sqrt(1-alpha), and R from J(0) = 1 / (1 + s).
double escape_probability(double one_minus_alpha, double x, double optical_depth);

}  // namespace alabaster
