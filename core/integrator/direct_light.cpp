#include "core/integrator/direct_light.h"

#include "core/integrator/interface.h"
#include "core/integrator/path_record.h"
#include "core/integrator/see_through.h"
#include "core/integrator/subsurface_scatter.h"
#include "core/sampling/mis.h"

namespace alabaster {
namespace {

// True where no light that is sampled in these media reaches the ray's origin from there.
bool is_sealed(const PathContext& context, const Ray& ray, const LightSample& light, const MediumStack& media) {
  if (!light.on_mesh || media.empty()) [[likely]]
    return false;
  const TriangleHit hit{light.distance, light.place.x, light.place.y, light.triangle, light.instance, context.time};
  return is_hidden_boundary(context, ray, hit, media) || is_lit_by_walks(context, media, hit);
}

// The share of the light that arrives at `p`, which is in these media.
Rgb visibility(const PathContext& context, const Vec3f& p, const LightSample& light, const MediumStack& media) {
  const Ray ray{p, light.wi, light.shadow_length(), context.time};
  if (is_sealed(context, ray, light, media)) return Rgb(0.0f);
  ++context.counters.shadow_rays;
  if (light.shadow_link != 0) [[unlikely]]
    return linked_visibility(context, ray, light.shadow_link, media);
  if (!context.sees_through() && !context.scene.features.clear_sheets)
    return Rgb(context.scene.top->occluded(ray) ? 0.0f : 1.0f);
  const Transmittance transmittance(context, ray.dir, media);
  return context.scene.top->occluded(ray, &transmittance) ? Rgb(0.0f) : transmittance.value();
}

// What the exit lobe at the vertex sends on of light that arrives, with the weight that it has at exits. Zero where the
// product is not finite, which depends on this sample alone.
Rgb sent_by_exit_lobe(const ScatterValue& value, const LightSample& light) {
  const float mis = light.delta || light.of_constant_dome ? 1.0f : power_heuristic(light.pdf, value.exit_pdf);
  const Rgb sent = light.radiance * (value.exit_cos * mis / light.pdf);
  return is_finite(sent) ? sent : Rgb(0.0f);
}

}  // namespace

bool reaches_smooth_surface(const PathContext& context, const Vertex& v) {
  ++context.counters.shadow_rays;
  const Vec3f& from = v.origins[Vertex::kFacet].p;
  return !context.scene.top->occluded({from, v.origins[Vertex::kSmooth].p - from, 1, context.time});
}

void catch_shadows(const PathContext& context, const Vertex& v, const MediumStack& media, FilmSample* out) {
  out->is_caught = true;
  if (is_cloudy(context, media)) return;
  const LightSet& lights = context.scene.lights_of(*v.instance);
  const LightSampleContext at(ConstantDomes::sampled, v.smooth_normal(), context.time);
  const RayOrigin& from = v.origins[Vertex::kFacet];
  for (size_t k = 0; k < lights.draws(at); ++k) {
    const std::optional<LightSample> light = lights.draw(k, from.p, from.horizon, v.u.light, at);
    if (!light || !v.is_above_facet(light->wi)) continue;
    const float cosine = dot(v.smooth_normal(), light->wi);
    if (!(cosine > 0)) continue;
    Rgb sent = light->radiance * (cosine * kInvPi / light->pdf);
    if (light->scales) sent *= light->scales->diffuse;
    if (!media.empty()) sent *= media.transmittance(light->distance);
    const Ray ray{from.p, light->wi, light->shadow_length(), context.time};
    if (!is_finite(sent) || is_sealed(context, ray, *light, media)) continue;
    const Rgb visible = visibility(context, from.p, *light, media);
    Rgb visible_there(1.0f);
    if (visible != visible_there) {
      ++context.counters.shadow_rays;
      visible_there = visibility_among_catchers(context, ray, light->shadow_link, media);
    }
    out->shadowed += sent * visible;
    out->unshadowed += sent * visible_there;
  }
}

void sample_lights(const PathContext& context, const VertexBsdf& bsdf, Vertex* vertex, Path* path) {
  if (!bsdf.has_lobes()) return;
  const Vertex& v = *vertex;
  ControlVariate* const control = vertex->control ? &*vertex->control : nullptr;
  PathRecord* const record = context.record;
  const LightSet& lights = context.scene.lights_of(*v.instance);
  LightSampleContext at = bsdf.light_context();
  at.time = context.time;
  const size_t draws = lights.draws(at);
  const auto branches = static_cast<float>(path->branches);
  const std::array<float, 4>& u = v.u.light;
  if (control && path->light_groups) [[unlikely]]
    control->by_group = path->light_groups->at_entry(path->branch_share < 1);
  if (control) control->dome_sample = lights.leading_dome_numbers(v.origins[Vertex::kFacet].p, u);

  Rgb direct(0.0f);
  for (const auto origin : {Vertex::kFacet, Vertex::kSmooth, Vertex::kFarSide}) {
    // Origins are sampled with a chance. Each direction is lit from its own one.
    const RayOrigin& from = v.origins[origin];
    if (!(u[3] < from.chance) || (origin == Vertex::kFarSide && !bsdf.scatters_beyond())) continue;
    std::optional<bool> reached;
    const MediumStack& media = origin == Vertex::kFarSide ? bsdf.media_beyond() : path->media;
    if (is_cloudy(context, media)) continue;
    for (uint32_t k = 0; k < draws; ++k) {
      // Sample a light, and evaluate the BSDF.
      const std::optional<LightSample> light = lights.draw(k, from.p, from.horizon, u, at);
      if (!light) continue;
      const ScatterValue value = bsdf.evaluate(light->wi, origin);
      const float pdf = value.pdf * branches;
      if (record && value.pdf > 0) record->sample_light(light->wi, value.f_cos, pdf);
      if (is_black(value.f_cos) && !(value.exit_cos > 0)) continue;

      // Trace the shadow ray.
      if (origin == Vertex::kSmooth && !reached) reached = reaches_smooth_surface(context, v);
      if (reached && !*reached) continue;
      const Rgb visible = visibility(context, from.p, *light, media);
      if (is_black(visible)) continue;

      // Add what arrives.
      const float mis = light->delta ? 1.0f : power_heuristic(light->pdf, pdf);
      Rgb arriving = value.f_cos * light->radiance * (mis / light->pdf) * visible;
      if (origin == Vertex::kSmooth) arriving *= 1 / from.chance;
      if (light->scales) [[unlikely]]
        arriving *= light->scales->of(value.specular);
      if (!media.empty()) arriving *= media.transmittance(light->distance);
      direct += arriving;
      if (path->layers) {
        const LobeScales* const scales = light->scales;
        const Rgb specular =
            scales ? share_of(value.specular * scales->specular, scales->of(value.specular)) : value.specular;
        const bool decides = path->seeks_layer();
        const Layer layer = decides ? Layer{Layer::Kind::local, specular, origin == Vertex::kFarSide} : path->layer;
        layer.add(path->throughput * arriving, decides || path->decided_here(), path->layers);
      }
      if (path->light_groups) [[unlikely]]
        path->add_to_group(light->group, path->throughput * arriving);
      if (record && !is_black(value.f_cos)) record->light_arrives(path->throughput * arriving, {light->pdf, mis});
      if (!control || !(value.exit_cos > 0)) continue;
      Rgb exit = sent_by_exit_lobe(value, *light) * visible;
      if (light->scales) exit *= light->scales->diffuse;
      if (origin == Vertex::kSmooth) exit *= 1 / from.chance;
      exit = path->through_media(exit, light->distance);
      control->light += exit;
      if (control->by_group) [[unlikely]]
        path->light_groups->add(light->group, exit, control->by_group);
    }
  }
  path->radiance += path->throughput * direct;

  // Add the expectation of the control variate.
  if (!control) return;
  control->light *= bsdf.exit_color();
  const Rgb factor = path->throughput * bsdf.subsurface_entry() * control->albedo;
  const Rgb expectation = factor * control->light;
  path->add_of_walks(expectation);
  if (control->by_group) [[unlikely]] {
    for (Rgb& light : *control->by_group) light *= bsdf.exit_color();
    path->add_to_groups(*control->by_group, factor);
  }
  if (record) record->add_flat_light(expectation);
}

}  // namespace alabaster
