#include "core/subsurface/medium.h"

#include <cmath>

#include "core/math/vector.h"

namespace alabaster {
namespace {

/// Larger extinctions are the same medium to any float ray, and products of them would overflow.
constexpr double kMaxSigmaT = 1e30;

double invert_chiang2016(double a) {
  return std::exp(a * (-5.09406 + a * (2.61188 - a * 4.31805)));  // eq. 1
}

double clamp_anisotropy(double g) {
  return std::isnan(g) ? 0 : std::clamp(g, -kMaxScatterAnisotropy, kMaxScatterAnisotropy);
}

/// sqrt(1 - alpha) = (1 - A) P(A)/Q(A): value and slope are right at both ends by construction, the largest error
/// of A between them is 1.7e-8. Derived by testenv/walks/fit_albedo_inversion.py.
double exact_s(double a) {
  constexpr double p[4] = {1, 1.90590733792, 0.722472222151, 0.00527736903751};
  constexpr double q[4] = {1, 3.35007585287, 3.22823189382, 0.813263477961};
  const double numerator = p[0] + a * (p[1] + a * (p[2] + a * p[3]));
  const double denominator = q[0] + a * (q[1] + a * (q[2] + a * q[3]));
  return (1 - a) * numerator / denominator;
}

/// The factor of s = sqrt((1 - alpha) / (1 - alpha g)) that obtains A where similarity alone does not; exactly one at
/// A = 0, A = 1 and g = 0. Rational in A and g; the largest error of A is 2e-5. Derived from discrete ordinates by
/// testenv/walks/fit_anisotropic_inversion.py.
double similarity_correction(double a, double g) {
  // A row per power of A, in it the powers of g.
  constexpr double n[3][3] = {{-0.323614373307, 0.154553316385, 0.0851628624009},
                              {-0.649744523581, 0.892011640201, -0.740493798357},
                              {0.930203503102, -0.744421765728, 0.872821487533}};
  constexpr double d[5][3] = {{1, -0.297160850548, -0.398359040884},
                              {7.65370666182, 2.34139892018, 0.386917926955},
                              {19.7927341167, 16.7297037447, -6.92267448229},
                              {34.0706540974, 44.5709652574, -0.811396241465},
                              {-7.90469479613, -10.5136824022, 6.76514448647}};
  const auto in_g = [g](const double(&row)[3]) { return row[0] + g * (row[1] + g * row[2]); };
  const double numerator = in_g(n[0]) + a * (in_g(n[1]) + a * in_g(n[2]));
  const double denominator = in_g(d[0]) + a * (in_g(d[1]) + a * (in_g(d[2]) + a * (in_g(d[3]) + a * in_g(d[4]))));
  return 1 + g * a * (1 - a) * numerator / denominator;
}

/// Van de Hulst (1980): A = (1-s)(1-.139 s)/(1+1.17 s), s = sqrt(1-alpha). This is s^2 for the root in [0,1] of
/// 0.139 s^2 - (1.139 + 1.17 A) s + (1 - A) = 0, in the form that does not cancel.
double invert_van_de_hulst(double a) {
  const double b = 1.139 + 1.17 * a;
  const double s = 2 * (1 - a) / (b + std::sqrt(b * b - 4 * 0.139 * (1 - a)));
  return s * s;
}

}  // namespace

double one_minus_alpha(double albedo, AlbedoInversion inversion, double g) {
  const double a = clamp_albedo(albedo);
  g = clamp_anisotropy(g);
  double alike = 0;  // 1 - alpha of the isotropic medium that is alike
  switch (inversion) {
    case AlbedoInversion::chiang2016:
      alike = invert_chiang2016(a);
      break;
    case AlbedoInversion::exact: {
      const double s = exact_s(a) * similarity_correction(a, g);
      alike = s * s;
      break;
    }
  }
  return alike * (1 - g) / (1 - g * alike);  // g = 0 changes no bit
}

float obtained_albedo(float albedo, AlbedoInversion inversion) {
  if (inversion == AlbedoInversion::exact) return static_cast<float>(clamp_albedo(albedo));
  const double s = std::sqrt(one_minus_alpha(albedo, inversion));
  // Van de Hulst's formula errs by 0.002; where it is told how much its inverse differs from the exact one, by 1e-9.
  double a = 0, correction = 0;
  for (int i = 0; i < 4; ++i) {
    const double t = s + correction;
    a = clamp_albedo((1 - t) * (1 - 0.139 * t) / (1 + 1.17 * t));
    correction = std::sqrt(invert_van_de_hulst(a)) - exact_s(a);
  }
  return static_cast<float>(a);
}

Rgb obtained_albedo(const Rgb& albedo, AlbedoInversion inversion) {
  return {obtained_albedo(albedo.r, inversion), obtained_albedo(albedo.g, inversion),
          obtained_albedo(albedo.b, inversion)};
}

Medium make_medium(const Rgb& albedo, const Rgb& scatter_distance, AlbedoInversion inversion, float g) {
  Medium medium;
  medium.albedo = albedo;
  medium.scatter_distance = scatter_distance;
  medium.g = static_cast<float>(clamp_anisotropy(g));
  for (int c = 0; c < 3; ++c) {
    const double distance = scatter_distance[c];
    if (!(distance > 0)) continue;  // NaN too
    const double complement = one_minus_alpha(albedo[c], inversion, medium.g);
    const double sigma_t = 1 / (distance * distance_scale(albedo[c]) * (1 - static_cast<double>(medium.g)));
    medium.active[c] = true;
    medium.sigma_t[c] = static_cast<float>(std::min(sigma_t, kMaxSigmaT));
    medium.alpha[c] = static_cast<float>(1 - complement);
    medium.one_minus_alpha[c] = static_cast<float>(complement);
  }
  return medium;
}

}  // namespace alabaster
