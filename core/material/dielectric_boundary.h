// The shares of light that a smooth boundary of two dielectrics reflects and lets through: exact Fresnel equations,
// with the tints of the Disney BSDF.
#pragma once

#include "core/material/disney_layers.h"
#include "core/material/disney_parameters.h"
#include "core/material/fresnel.h"
#include "core/material/microfacet.h"
#include "core/material/thin_film.h"

namespace alabaster {

struct DielectricBoundary {
  float eta = 1.5f;        // index of the far side over that of the viewer's side; of a sheet: its own over that around
  Rgb reflection{1.0f};    // tint, at most 1
  Rgb transmission{1.0f};  // tint, at most 1
  ThinFilm film{};
  bool film_beyond = false;  // on the far side
  /// The layers of the far side. Light that they do not let out comes back: `passed` does not have their factor.
  std::optional<DisneyLayers> layers_beyond = {};
  bool sheet = false;  // both faces of one, with all light that goes back and forth between them

  /// A tint of the reflection, by specular, specularColor and specularTint, lets through what it does not reflect.
  static DielectricBoundary from(const DisneyParameters& p, float eta, const Rgb& transmission,
                                 bool film_beyond = false) {
    const Rgb hue = p.specular_tint > 0 ? lerp(Rgb(1.0f), tint(p.base_color), p.specular_tint) : Rgb(1.0f);
    return {eta, clamp01(hue * p.specular_color) * p.specular, transmission, ThinFilm::of(p), film_beyond};
  }

  struct Shares {
    Rgb reflected, passed;
    float chance = 0;  // of choosing reflection
  };
  /// `cosine` > 0 of incidence.
  Shares shares(float cosine) const {
    const float f = fresnel_dielectric(cosine, eta);
    // Total reflection is not tinted: no other light would take up the rest.
    if (!(f < 1)) return {Rgb(1.0f), Rgb(0.0f), 1};
    // The film reflects as much of the light that comes from the other side.
    const float beyond = film_beyond || layers_beyond ? cosine_refracted(cosine, eta) : 0;
    const Rgb fresnel =
        film.share > 0 ? film.over(Rgb(f), film_beyond ? beyond : cosine, Rgb(f0_from_ior(eta))) : Rgb(f);
    const Rgb entered = Rgb(1.0f) - fresnel * max_component(reflection);
    Shares s{reflection * fresnel, transmission * entered};
    if (sheet) {  // what came in has the tint once, whichever way it leaves
      for (int c = 0; c < 3; ++c) {
        if (!(entered[c] > 0)) continue;
        s.passed[c] = transmission[c] * sqr(entered[c]) / (1 - sqr(s.reflected[c]));
        s.reflected[c] *= 1 + s.passed[c];
      }
    }
    if (layers_beyond) s.reflected += s.passed * transmission * layers_beyond->held_back(beyond);
    const float reflected = choice_weight(s.reflected), passed = choice_weight(s.passed);
    if (reflected > 0) s.chance = reflected / (reflected + passed);
    return s;
  }
  /// What passes straight on. Facets of roughness alpha lean towards the viewer, where a film may reflect more than
  /// the flat one does: then at most what those leave at cosines that slopes of up to four times alpha give.
  Rgb passed_straight(float cosine, float alpha) const {
    Rgb passed = shares(cosine).passed;
    if (!(film.share > 0) || alpha <= kMinAlpha) return passed;
    for (const float slopes : {0.25f, 0.5f, 1.0f, 2.0f, 4.0f}) {
      const Rgb reflected = shares(lerp(cosine, 1.0f, std::min(1.0f, slopes * alpha))).reflected;
      for (int c = 0; c < 3; ++c) passed[c] = std::min(passed[c], std::max(1 - reflected[c], 0.0f));
    }
    return passed;
  }
  /// Estimate of what a rough boundary reflects and lets through: as one that lies flat, but of reflection at least
  /// what tilted facets give.
  Rgb albedo(float cosine) const {
    const Shares s = shares(cosine);
    return s.reflected + s.passed + Rgb(1.0f / 21);
  }
};

}  // namespace alabaster
