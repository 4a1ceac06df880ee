// From what an artist says (surface albedo A, scatter distance d) to what a walk needs (sigma_t, alpha).
// Chiang, Kutz, Burley 2016, section 2.
#pragma once

#include "core/color/rgb.h"

namespace alabaster {

/// How albedo A is inverted to the single-scattering albedo alpha.
enum class AlbedoInversion {
  chiang2016,    // the paper's eq. 1: obtains 0.926 at A = 1
  exact,         // rational fit of the inverse of Chandrasekhar's H-function result
  van_de_hulst,  // A = (1-s)(1-.139 s)/(1+1.17 s), s = sqrt(1-alpha)
};

/// 1 - alpha for A in [0,1] (clamped; NaN -> A = 0). The complement is carried because alpha = 1 - 2e-9 has no float.
double one_minus_alpha(double albedo, AlbedoInversion inversion);

/// Chandrasekhar H-function for isotropic scattering, mu in [0,1], by the closed form
/// ln H = -(mu/pi) Int_0^{pi/2} ln(1 - alpha t cot t) / (cos^2 t + mu^2 sin^2 t) dt. Slow; for tests and tables.
double chandrasekhar_h(double mu, double one_minus_alpha);

/// An index-matched half-space of isotropic scatterers, cosine entry: the albedo that a given 1 - alpha yields
/// (Chandrasekhar 1960: A = 1 - 2 sqrt(1-alpha) Int_0^1 mu H(mu) dmu). Slow; for tests and tables.
double half_space_albedo(double one_minus_alpha);

/// The albedo that a walk shows when asked for `albedo`: the same but for the inversions that err. Within 1e-6 of
/// half_space_albedo(one_minus_alpha(albedo, inversion)), and fast.
float obtained_albedo(float albedo, AlbedoInversion inversion);

/// Eq. 2: s = 1.9 - A + 3.5 (A - 0.8)^2.
double distance_scale(double albedo);

struct Medium {
  Rgb sigma_t{0.0f};                       // 1/world unit, eq. 3: 1/(d s); channels that do not scatter have 0
  Rgb alpha{0.0f};                         // single-scattering albedo
  Rgb one_minus_alpha{1.0f};               // carried separately: see above
  bool active[3] = {false, false, false};  // channels with scatter_distance > 0
};

Medium make_medium(const Rgb& albedo, const Rgb& scatter_distance, AlbedoInversion inversion);

}  // namespace alabaster
