// Next-event estimation: one direction for each sampled light, weighed against the sampling of the lobe by the power
// heuristic. The other half of the weight is taken where a lobe's ray meets a light (path_integrator.cpp,
// analytic_light_emission and add_mesh_emission).
#pragma once

#include "core/integrator/path_state.h"
#include "core/integrator/see_through.h"
#include "core/sampling/mis.h"

namespace alabaster {

/// The value of a scattering function for a direction.
struct ScatterValue {
  Rgb f_cos{0.0f};
  float pdf = 0;                     // of sampling the direction, times the number of directions that are sampled
  Rgb specular_share{0.0f};          // of f, per channel; only where layers are split
  float exit_cos = 0, exit_pdf = 0;  // f cos and pdf of an exit lobe; only where FlatExit::light is sought
};

/// The weight of a sampled light.
struct LightWeight {
  float pdf;  // of sampling the direction, with the choice of light
  float mis;  // against sampling of the lobe
  float distance = 0;
  Rgb exit_light{0.0f};  // that the exit lobe of ScatterValue sends on, with the weight that it has at exits
};

/// The share of the light that arrives at `p`. `within`: the interiors that p is in; null: none.
inline float visibility(const PathContext& context, const Vec3f& p, const LightSample& light, const Interiors* within) {
  ++context.counters.shadow_rays;
  const Ray ray{p, light.wi, light.shadow_length(), context.time};
  if (light.shadow_link != 0) [[unlikely]]
    return linked_visibility(context.scene, ray, light.shadow_link, within);
  if (!context.sees_through()) return context.scene.top->occluded(ray) ? 0.0f : 1.0f;
  const Transmittance transmittance(context.scene, ray.dir, within);
  return context.scene.top->occluded(ray, &transmittance) ? 0.0f : transmittance.value();
}

/// LightWeight::exit_light. Zero where the product is not finite, which depends on this sample alone.
inline Rgb exit_light(const ScatterValue& value, const LightSample& light, float arrives) {
  const float weight = light.delta || light.of_constant_dome ? 1.0f : power_heuristic(light.pdf, value.exit_pdf);
  const Rgb sent = light.radiance * (value.exit_cos * arrives * weight / light.pdf);
  return is_finite(sent) ? sent : Rgb(0.0f);
}

/// Inputs of next-event estimation at a point: lights, random numbers, search.
struct DirectLightInputs {
  const LightSet& lights;
  std::array<float, 4> u;
  LightSearch search;
  const Interiors* within;  // that the point is in; null: none
};

/// Light scattered at `p` (already offset to the outer side) from the lights that are sampled there. No direction below
/// either plane of `horizon` may scatter. `scatter(wi)` gives the ScatterValue for a unit direction in render space; a
/// zero value costs no ray. Calls `add(value, light, weight)` for each light that arrives.
template <class Scatter, class Add>
void for_direct_light(const PathContext& context, const Vec3f& p, const Horizon& horizon,
                      const DirectLightInputs& inputs, const Scatter& scatter, const Add& add) {
  inputs.lights.sample_lights(p, horizon, inputs.u, inputs.search, [&](const LightSample& light) {
    const ScatterValue value = scatter(light.wi);
    if (is_black(value.f_cos) && !(value.exit_cos > 0)) return;
    const float arrives = visibility(context, p, light, inputs.within);
    if (!(arrives > 0)) return;
    const float weight = light.delta ? 1.0f : power_heuristic(light.pdf, value.pdf);
    LightWeight how{light.pdf, weight, light.distance};
    if (value.exit_cos > 0) how.exit_light = exit_light(value, light, arrives);
    add(value, value.f_cos * light.radiance * (arrives * weight / light.pdf), how);
  });
}

/// True if no geometry lies between the facet and the curved surface over it: where bodies touch, light must not slip
/// in between them.
inline bool reaches_curved_surface(const PathContext& context, const Departure& from) {
  ++context.counters.shadow_rays;
  return !context.scene.top->occluded({from.flat, from.curved - from.flat, 1, context.time});
}

/// Origin of a ray in direction `wi`.
inline Vec3f origin_of(const PathContext& context, const Departure& from, const Vec3f& wi) {
  return from.wedge > 0 && !from.is_above(wi) && reaches_curved_surface(context, from) ? from.curved : from.flat;
}

/// Light scattered at a departure: each direction is lit from its own origin. Lights are sampled from the curved
/// surface with a probability that falls with the wedge, which is small where the mesh is fine.
template <class Scatter, class Add>
void for_direct_light(const PathContext& context, const Departure& from, const DirectLightInputs& inputs,
                      const Scatter& scatter, const Add& add) {
  const auto above = [&](const Vec3f& wi) { return from.is_above(wi) ? scatter(wi) : ScatterValue(); };
  for_direct_light(context, from.flat, {from.ng, from.n}, inputs, above, add);
  const float chance = std::min(1.0f, 8 * from.wedge);
  if (!(inputs.u[3] < chance)) return;
  std::optional<bool> reached;
  const auto below = [&](const Vec3f& wi) {
    const ScatterValue value = from.is_above(wi) ? ScatterValue() : scatter(wi);
    if (is_black(value.f_cos) && !(value.exit_cos > 0)) return ScatterValue();
    if (!reached) reached = reaches_curved_surface(context, from);
    return *reached ? value : ScatterValue();
  };
  for_direct_light(context, from.curved, {from.n, from.n}, inputs, below,
                   [&](const ScatterValue& value, const Rgb& light, LightWeight weight) {
                     weight.exit_light *= 1 / chance;
                     add(value, light * (1 / chance), weight);
                   });
}

}  // namespace alabaster
