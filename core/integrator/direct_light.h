// Next-event estimation: one direction for each sampled light, weighed against the sampling of the lobe by the power
// heuristic. The other half of the weight is taken where a lobe's ray meets a light (path_integrator.cpp,
// add_light_emission).
#pragma once

#include "core/integrator/path_state.h"
#include "core/sampling/mis.h"

namespace alabaster {

/// What a scattering function answers for a direction: f times the cosine, and the pdf of sampling it.
struct ScatterValue {
  Rgb f_cos{0.0f};
  float pdf = 0;
};

/// A shadow ray to a point on an emissive mesh stops this fraction short of it, so that the light does not shade
/// itself. Lights that are no geometry need no such margin.
inline constexpr float kMeshLightFraction = 1 - 0x1p-12f;

inline bool is_occluded(const PathContext& context, const Vec3f& p, const LightSample& light) {
  ++context.counters.shadow_rays;
  return context.scene.top->occluded(
      {p, light.wi, light.on_mesh ? light.distance * kMeshLightFraction : light.distance});
}

/// Light scattered at `p` (already offset to the outer side) from the lights that are sampled there. `scatter(wi)`
/// gives the ScatterValue for a unit direction in render space; a zero value costs no ray. Calls `add(wi, light)` for
/// each light that arrives.
template <class Scatter, class Add>
void for_direct_light(const PathContext& context, const Vec3f& p, const std::array<float, 4>& u, const Scatter& scatter,
                      const Add& add) {
  context.scene.lights.sample_lights(p, u, [&](const LightSample& light) {
    const ScatterValue value = scatter(light.wi);
    if (is_black(value.f_cos) || is_occluded(context, p, light)) return;
    const float weight = light.delta ? 1.0f : power_heuristic(light.pdf, value.pdf);
    add(light.wi, value.f_cos * light.radiance * (weight / light.pdf));
  });
}

/// Whether nothing lies between the facet and the curved surface over it: where bodies touch, light must not slip
/// through what is between them.
inline bool stands_free(const PathContext& context, const Departure& from) {
  ++context.counters.shadow_rays;
  return !context.scene.top->occluded({from.flat, from.curved - from.flat, 1});
}

/// Origin of a ray in direction `wi`.
inline Vec3f origin_of(const PathContext& context, const Departure& from, const Vec3f& wi) {
  return from.wedge > 0 && !from.is_above(wi) && stands_free(context, from) ? from.curved : from.flat;
}

/// The same for both origins. The wedge is small where the mesh is fine, and lights are sampled from there as seldom.
template <class Scatter, class Add>
void for_direct_light(const PathContext& context, const Departure& from, const std::array<float, 4>& u,
                      const Scatter& scatter, const Add& add) {
  const auto above = [&](const Vec3f& wi) { return from.is_above(wi) ? scatter(wi) : ScatterValue(); };
  for_direct_light(context, from.flat, u, above, add);
  const float chance = std::min(1.0f, 8 * from.wedge);
  if (!(u[3] < chance)) return;
  std::optional<bool> free;
  const auto below = [&](const Vec3f& wi) {
    const ScatterValue value = from.is_above(wi) ? ScatterValue() : scatter(wi);
    if (is_black(value.f_cos)) return ScatterValue();
    if (!free) free = stands_free(context, from);
    return *free ? value : ScatterValue();
  };
  for_direct_light(context, from.curved, u, below,
                   [&](const Vec3f& wi, const Rgb& light) { add(wi, light * (1 / chance)); });
}

/// Its sum.
template <class Scatter>
Rgb direct_light(const PathContext& context, const Departure& from, const std::array<float, 4>& u,
                 const Scatter& scatter) {
  Rgb sum(0.0f);
  for_direct_light(context, from, u, scatter, [&](const Vec3f&, const Rgb& light) { sum += light; });
  return sum;
}

}  // namespace alabaster
