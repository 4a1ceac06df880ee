// The layers that dim what lies below them: a coat, and fibres under it. Factors of the lobes below for a pair of
// directions; each is reciprocal.
#pragma once

#include <optional>

#include "core/material/charlie_sheen.h"
#include "core/material/disney_coat.h"

namespace alabaster {

/// The colour of both kinds of sheen, at strength 1.
inline Rgb sheen_hue(const DisneyParameters& p) {
  return lerp(Rgb(1.0f), tint(p.base_color), p.sheen_tint) * p.sheen_color;
}

/// The mean of f(cosine) over directions, as Lambert's law has it: by the Gauss-Jacobi rule of three points, which is
/// exact for Schlick's weight.
template <class F>
auto mean_of_cosines(const F& f) {
  return f(0.2123405382f) * 0.1396539598f + f(0.5905331356f) * 0.4584822128f + f(0.9114120405f) * 0.4018638274f;
}

/// Directions lie on the side that the layers are on; w.z is the cosine to the surface. The coat's `passage` is a
/// factor of its own, once for each time that light passes it.
struct DisneyLayers {
  CharlieSheen fibres;  // with a roughness: in the place of Burley's sheen, and over all but the coat
  DisneyCoat coat;      // with a weight: in the place of Burley's clearcoat, and over the rest

  /// Empty: few materials have any, and the others do not pay for them.
  static std::optional<DisneyLayers> of(const DisneyParameters& p) {
    if (!p.has_dimming_layers()) return std::nullopt;
    DisneyLayers layers;
    if (p.sheen > 0 && p.sheen_roughness > 0)
      layers.fibres = CharlieSheen::from(clamp01(sheen_hue(p) * p.sheen), p.sheen_roughness);
    if (p.coat > 0) layers.coat = DisneyCoat::from(p);
    return layers;
  }

  bool fibrous() const { return fibres.roughness > 0; }
  bool coated() const { return coat.weight > 0; }

  /// The share of light that they let in or out along `w`.
  float passed(const Vec3f& w) const { return (fibrous() ? fibres.passed(w.z) : 1) * (coated() ? coat.passed(w) : 1); }
  /// The share of light from below, at this cosine, that they send back instead of letting it out.
  Rgb held_back(float cosine) const {
    const float fibres_pass = fibrous() ? fibres.passed(cosine) : 1, coat_passes = coated() ? coat.passed(cosine) : 1;
    const Rgb by_coat = coat.passage * coat.passage * (fibres_pass * (1 - coat_passes));
    return fibrous() ? by_coat + fibres.color * ((1 - fibres_pass) / max_component(fibres.color)) : by_coat;
  }
  /// held_back() of light in all directions, as Lambert's law has it.
  Rgb mean_held_back() const {
    return mean_of_cosines([&](float cosine) { return held_back(cosine); });
  }
  /// The factor of lobes that reflect into all directions.
  float over_diffuse(const Vec3f& wo, const Vec3f& wi) const {
    return (fibrous() ? fibres.over(wo.z, wi.z) : 1) * (coated() ? coat.over_diffuse(wo, wi) : 1);
  }
  /// The layers as light met them on its way in, for its way out elsewhere.
  struct Entered {
    float fibres = 1;  // the share that they let pass
    float coat = 1;    // the share that it lets pass of light from everywhere
  };
  Entered entered(const Vec3f& wo) const {
    return {fibrous() ? fibres.passed(wo.z) : 1, coated() ? coat.mean_passed() : 1};
  }
  /// Those over light that began below them: it comes from everywhere.
  Entered from_within() const {
    const auto passed = [&](float cosine) { return fibres.passed(cosine); };
    return {fibrous() ? mean_of_cosines(passed) : 1, coated() ? coat.mean_passed_at_exit() : 1};
  }
  /// The factor of light that leaves along `wi` where these layers are, of a weight passed(wo) where it entered. With
  /// that it is over_diffuse() where the layers are alike; where they differ it is reciprocal as well, and keeps
  /// energy.
  float leaving(const Vec3f& wi, const Entered& from) const {
    float left = coated() ? coat.passed(wi) / std::max(coat.mean_passed(), from.coat) : 1;
    if (fibrous()) left *= from.fibres > 0 ? std::min(1.0f, fibres.passed(wi.z) / from.fibres) : 0;
    return left;
  }
  /// The factor of a clear boundary below them. Never more than passed() of either direction: the boundary itself sends
  /// on all that it receives.
  float over_clear(const Vec3f& wo, const Vec3f& wi) const {
    return (fibrous() ? fibres.over(wo.z, wi.z) : 1) * (coated() ? std::min(coat.passed(wo), coat.passed(wi)) : 1);
  }
};

}  // namespace alabaster
