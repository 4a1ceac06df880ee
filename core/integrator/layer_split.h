// Sorts a path's light by the lobe that scattered it at the first surface the camera sees.
#pragma once

#include "core/film/film.h"

namespace alabaster {

/// part / all per channel; 0 where all is 0.
inline Rgb share_of(const Rgb& part, const Rgb& all) {
  Rgb share;
  for (int c = 0; c < 3; ++c) share[c] = all[c] > 0 ? part[c] / all[c] : 0;
  return share;
}

/// The first walk of a path below the surface.
struct WalkLayers {
  uint32_t events;  // of scattering
  Rgb twin_light;   // that its twin took: of all numbers of events, so it counts as many
};

/// The state of a path at its first vertex, which decides the layers. A direction is sampled with the f of all local
/// lobes together, so light that comes back along it belongs to each group by the group's share of that f, per channel:
/// the estimate of a group is then the one that f_group alone would give, unbiased, and the groups add up to the path.
struct LayerSplit {
  Rgb emission{0.0f};                             // seen directly
  bool scattered = false;                         // false: no such vertex, all light is seen directly
  Rgb local_diffuse{0.0f}, local_specular{0.0f};  // scattered at the vertex itself, gathered so far
  LightLayers below;                              // what its paths below brought out
  // These are set where a path goes on undivided, from a surface that lets light through.
  Rgb gathered{0.0f};        // the path's radiance when it left the vertex
  Rgb specular_share{0.0f};  // of f in the direction that it left in
  bool went_on = false;      // it left from the surface

  void add_local(const Rgb& light, const Rgb& share) {
    local_specular += light * share;
    local_diffuse += light - light * share;
  }

  /// Light of one path that went below the surface.
  void add_below(const Rgb& light, const WalkLayers& walk) {
    (walk.events == 0   ? below.unscattered
     : walk.events == 1 ? below.single
                        : below.multiple) += light - walk.twin_light;
    below.multiple += walk.twin_light;
  }

  /// `radiance`: all light of the finished path.
  LightLayers finish(const Rgb& radiance) {
    LightLayers layers = below;
    layers.emission = scattered ? emission : radiance;
    if (!scattered) return layers;
    if (went_on) add_local(radiance - gathered, specular_share);
    layers.diffuse = local_diffuse;
    layers.specular = local_specular;
    return layers;
  }
};

}  // namespace alabaster
