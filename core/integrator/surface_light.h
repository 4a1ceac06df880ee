// Direct light at a surface whose lobes all stay on the viewer's side, and what walks below it need of it.
#pragma once

#include "core/integrator/direct_light.h"
#include "core/integrator/layer_split.h"
#include "core/integrator/path_record.h"
#include "core/integrator/subsurface_scatter.h"
#include "core/material/disney_bsdf.h"

namespace alabaster {

/// Paths that a path becomes at the surface that the camera sees, unless that lets light through. The camera's ray and
/// the lights sampled there give little of the noise, and what comes by way of bodies and other surfaces gives much.
/// More than two gain beyond doubt on skin alone (testenv/benchmark/results/sampling.md).
inline constexpr uint32_t kPathsPerSample = 2;

/// A surface whose lobes send the path on, and below which it may go.
struct LobedVertex {
  const PathVertex& v;
  const DisneyBsdf& bsdf;
  std::optional<FlatExit> flat = {};      // VertexBelow's
  std::optional<VertexBelow> below = {};  // made once it is needed
};

/// The record of a path, where the integrator can write one. Variants without layers do not ask at a vertex.
template <bool kLayers>
PathRecord* record_of(const PathContext& context) {
  return kLayers ? context.record : nullptr;
}

/// Adds the expectation of the control variate, of which walks subtract their samples.
template <bool kLayers>
void add_flat_light(const PathContext& context, const LobedVertex& at, PathState* path, LayerSplit* split) {
  const Rgb light = path->throughput * at.bsdf.subsurface_entry() *
                    obtained_albedo(at.v.material.base_color, context.settings.inversion) * at.flat->light;
  path->radiance += light;
  if (PathRecord* record = record_of<kLayers>(context)) record->add_flat_light(light);
  if (kLayers && path->depth == 0) split->below.multiple += light;
}

/// Samples the lights. Sets at->flat where walks have twins.
template <SubsurfaceMode kMode, bool kLayers>
void add_direct_light(const PathContext& context, const std::array<float, 4>& u, LobedVertex* at, PathState* path,
                      LayerSplit* split) {
  const PathVertex& v = at->v;
  const bool splits = kLayers && path->depth == 0;
  PathRecord* const record = record_of<kLayers>(context);
  const float directions = path->depth == 0 ? static_cast<float>(kPathsPerSample) : 1.0f;
  const bool walks = kMode != SubsurfaceMode::lambert && v.material.scatters();
  if (walks && has_twins<kMode>(context, v.material) && !is_black(at->bsdf.subsurface_entry()))
    at->flat.emplace().numbers = u;
  const auto local_lobes = [&](const Vec3f& wi_world) -> ScatterValue {
    const Vec3f wi = v.frame.to_local(wi_world);
    if (!at->bsdf.reaches(wi) || !v.is_above_surface(wi_world)) return {};
    Rgb specular;
    const BsdfValue value = at->bsdf.evaluate(wi, splits ? &specular : nullptr);
    const float pdf = value.pdf * directions;
    const float cosine = std::abs(wi.z);
    if (record) record->sample_light(wi_world, value.f * cosine, pdf);
    ScatterValue scattered{value.f * cosine, pdf, splits ? share_of(specular, value.f) : Rgb(0.0f)};
    if (at->flat) scattered.exit_cos = at->bsdf.subsurface_exit(wi) * wi.z, scattered.exit_pdf = wi.z * kInvPi;
    return scattered;
  };
  Rgb direct(0.0f);
  path->search = {walks ? ConstantDomes::sampled : ConstantDomes::bsdf_sampling_only, v.frame.n};
  path->lights = &context.scene.lights_of(*v.instance);
  if (at->flat) at->flat->onward = path->lights->leading_dome_numbers(v.departure.flat, u);
  for_direct_light(context, v.departure, {*path->lights, u, path->search, &path->interiors}, local_lobes,
                   [&](const ScatterValue& value, const Rgb& arriving, const LightWeight& weight) {
                     const Rgb light = path->through_interiors(arriving, weight.distance);
                     direct += light;
                     if (at->flat) at->flat->light += path->through_interiors(weight.exit_light, weight.distance);
                     if (record && !is_black(value.f_cos)) record->light_arrives(path->throughput * light, weight);
                     if (splits) split->add_local(path->throughput * light, value.specular_share);
                   });
  path->radiance += path->throughput * direct;
  if (at->flat) add_flat_light<kLayers>(context, *at, path, split);
}

}  // namespace alabaster
