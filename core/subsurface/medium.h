// From an artist's parameters (surface albedo A, scatter distance d) to those of a walk (sigma_t, alpha).
// Chiang, Kutz, Burley 2016, section 2.
#pragma once

#include "core/color/rgb.h"
#include "core/material/scatter_distance.h"

namespace alabaster {

/// The inversion from albedo A to the single-scattering albedo alpha.
enum class AlbedoInversion {
  chiang2016,  // the paper's eq. 1: obtains 0.926 at A = 1
  exact,       // rational fit of the inverse of Chandrasekhar's H-function result, and of the transport equation's at
               // g != 0: within 2e-8 of the albedo asked at g = 0, within 2e-5 of it at any g
};

/// g beyond this is clamped: the albedo inversion was fitted and measured up to here.
inline constexpr double kMaxScatterAnisotropy = 0.9;

/// 1 - alpha for A in [0,1] and Henyey-Greenstein g in [-0.9, 0.9] (both clamped; NaN -> 0). The complement is carried
/// because alpha = 1 - 2e-9 has no float. Only `exact` covers g: chiang2016 is an inversion for
/// isotropic scattering, which g turns into the medium alike by similarity, alpha' = alpha (1-g) / (1 - alpha g) (van
/// de Hulst 1980, chapter 14). That alone is off by up to 0.003 in A for g > 0, by up to 0.026 for g < 0.
double one_minus_alpha(double albedo, AlbedoInversion inversion, double g = 0);

/// The albedo that a walk shows when asked for `albedo`: the same but for the inversions that err. Within 1e-6 of
/// Chandrasekhar's half-space (1960: A = 1 - 2 sqrt(1-alpha) Int_0^1 mu H(mu) dmu), and fast.
float obtained_albedo(float albedo, AlbedoInversion inversion);
Rgb obtained_albedo(const Rgb& albedo, AlbedoInversion inversion);

struct Medium {
  Rgb albedo{0.0f}, scatter_distance{0.0f};  // as asked: A and d, world
  Rgb sigma_t{0.0f};                         // 1/world unit: 1/(d s (1-g)); channels that do not scatter have 0
  Rgb alpha{0.0f};                           // single-scattering albedo
  Rgb one_minus_alpha{1.0f};                 // carried separately: see above
  bool active[3] = {false, false, false};    // channels with scatter_distance > 0
  float g = 0;                               // Henyey-Greenstein: mean cosine of scattering, in [-0.9, 0.9]
};

/// Eq. 3 gives the reduced extinction, sigma_t (1-g) = 1/(d s): so scatterDistance keeps its meaning over g. At equal A
/// and d the mean distance between entry and exit stays within 3 % for g in [0, 0.9] and A >= 0.5, falls by a fifth at
/// A = 0.2, g = 0.9 and by more in darker media, and falls where light is thrown back at once, g < 0
/// (testenv/statistical/results/anisotropy.md).
Medium make_medium(const Rgb& albedo, const Rgb& scatter_distance, AlbedoInversion inversion, float g = 0);

}  // namespace alabaster
