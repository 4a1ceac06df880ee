#include "testenv/support/disney_reference.h"

#include <cmath>

namespace alabaster::testing {
namespace {

const double kPiExact = std::acos(-1.0);

struct Angles {
  double theta, phi;
  explicit Angles(const Vec3d& w) : theta(std::atan2(std::hypot(w.x, w.y), w.z)), phi(std::atan2(w.y, w.x)) {}
};

double mix(double a, double b, double t) {
  return (1 - t) * a + t * b;
}

double schlick_falloff(double theta) {
  return std::pow(1 - std::cos(theta), 5);
}

/// Smith's G1 = 1 / (1 + Lambda) for anisotropic GGX.
double masking(const Angles& w, double ax, double ay) {
  const double a = std::hypot(ax * std::cos(w.phi), ay * std::sin(w.phi)) * std::tan(w.theta);
  const double lambda = 0.5 * (std::sqrt(1 + a * a) - 1);
  return 1 / (1 + lambda);
}

double gtr2(const Angles& h, double ax, double ay) {
  const double c = std::cos(h.theta), t = std::tan(h.theta);
  const double e = std::pow(std::cos(h.phi) / ax, 2) + std::pow(std::sin(h.phi) / ay, 2);
  return 1 / (kPiExact * ax * ay * std::pow(c, 4) * std::pow(1 + t * t * e, 2));
}

double gtr1(const Angles& h, double a) {
  return (a * a - 1) / (2 * kPiExact * std::log(a)) / (1 + (a * a - 1) * std::pow(std::cos(h.theta), 2));
}

}  // namespace

ReferenceTerms disney_reference_2012(const ReferenceParameters& p, const Vec3d& wo, const Vec3d& wi) {
  const Angles v(wo), l(wi), h(normalize(wo + wi));
  const double theta_d = 0.5 * std::atan2(length(cross(wo, wi)), dot(wo, wi));
  const double fd90 = 0.5 + 2 * p.roughness * std::pow(std::cos(theta_d), 2);
  const double diffuse =
      (1 + (fd90 - 1) * schlick_falloff(l.theta)) * (1 + (fd90 - 1) * schlick_falloff(v.theta)) / kPiExact;
  const double fh = schlick_falloff(theta_d);

  const double aspect = std::sqrt(1 - 0.9 * p.anisotropic);
  const double ax = p.roughness * p.roughness / aspect, ay = p.roughness * p.roughness * aspect;
  const double jacobian = 4 * std::cos(l.theta) * std::cos(v.theta);
  const double microfacet = gtr2(h, ax, ay) * masking(l, ax, ay) * masking(v, ax, ay) / jacobian;
  const double coat_g = masking(l, 0.25, 0.25) * masking(v, 0.25, 0.25) / jacobian;

  const auto& c = p.base_color;
  const double y = 0.3 * c[0] + 0.6 * c[1] + 0.1 * c[2];
  const double f0 = std::pow((p.ior - 1) / (p.ior + 1), 2);
  ReferenceTerms terms{};
  for (size_t i = 0; i < 3; ++i) {
    const double hue = y > 0 ? c[i] / y : 1;
    terms.diffuse[i] = (1 - p.metallic) * c[i] * diffuse;
    terms.sheen[i] = (1 - p.metallic) * p.sheen * mix(1, hue, p.sheen_tint) * fh;
    const double specular0 = mix(f0 * mix(1, hue, p.specular_tint), c[i], p.metallic);
    terms.specular[i] = mix(specular0, 1, fh) * microfacet;
  }
  terms.clearcoat = 0.25 * p.clearcoat * mix(0.04, 1, fh) * gtr1(h, mix(0.1, 0.001, p.clearcoat_gloss)) * coat_g;
  return terms;
}

}  // namespace alabaster::testing
