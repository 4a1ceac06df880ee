// Sorts a path's light by the lobe that scattered it at the first surface the camera sees.
#pragma once

#include "core/film/film.h"

namespace alabaster {

/// What of a path's first vertex decides the layers. A direction is sampled with the f of all local lobes together, so
/// what comes back along it belongs to each group by its share of that f, per channel: the estimate of a group is then
/// the one that f_group alone would give, unbiased, and the groups add up to the path.
struct LayerSplit {
  Rgb emission{0.0f};                             // seen directly
  bool scattered = false;                         // there was such a vertex; if not, all is seen directly
  Rgb local_diffuse{0.0f}, local_specular{0.0f};  // scattered at the vertex itself, gathered so far
  Rgb gathered{0.0f};                             // the path's radiance when it left the vertex
  Rgb specular_share{0.0f};                       // of the direction that it left in
  bool below = false;                             // it left into the body,
  uint32_t events = 0;                            // and scattered so often in it

  void add_local(const Rgb& light, const Rgb& share) {
    local_specular += light * share;
    local_diffuse += light - light * share;
  }

  /// `radiance`: all that the path has brought.
  LightLayers finish(const Rgb& radiance) {
    LightLayers layers;
    layers.emission = scattered ? emission : radiance;
    if (!scattered) return layers;
    const Rgb later = radiance - gathered;
    if (below)
      (events == 0 ? layers.unscattered : events == 1 ? layers.single : layers.multiple) = later;
    else
      add_local(later, specular_share);
    layers.diffuse = local_diffuse;
    layers.specular = local_specular;
    return layers;
  }
};

}  // namespace alabaster
