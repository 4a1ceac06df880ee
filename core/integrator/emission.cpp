#include "core/integrator/emission.h"

#include "core/integrator/see_through.h"
#include "core/sampling/mis.h"

namespace alabaster {
namespace {

float mis_weight(const Path& path, float light_pdf) {
  return path.pdf > 0 ? power_heuristic(path.pdf, light_pdf) : 1.0f;
}

// The path's segment as a ray from where light was sampled, before the sheets that the path went straight through.
Ray ray_from_vertex(const Path& path) {
  if (!(path.straight > 0)) return path.ray;
  return {path.light_origin, path.ray.dir, path.straight + path.ray.tmax, path.ray.time};
}

// `note` gets each light's term of the sum, which the throughput multiplies.
template <class Note>
Rgb linked_light_emission(const PathContext& context, const Path& path, bool escaped, const LobeShares* shares,
                          const Note& note) {
  const auto weigh = [&path](float light_pdf) { return mis_weight(path, light_pdf); };
  const bool is_clear = escaped && !context.sees_through();
  Rgb light(0.0f);
  path.lights->each_emitted_with_links(
      path.ray, path.light_context, weigh,
      [&](uint32_t link, float distance) -> Rgb {
        if (path.hidden_boundary && !context.scene.casts_shadow(*path.hidden_boundary, link)) return Rgb(0.0f);
        const Ray ray{path.ray.org, path.ray.dir, distance, path.ray.time};
        if (is_clear) return path.through_media(Rgb(1.0f), distance);
        ++context.counters.shadow_rays;
        return path.through_media(linked_visibility(context, ray, link, path.media), distance);
      },
      shares, [&](size_t i, const Rgb& term) { light += term, note(i, term); });
  return light;
}

template <class Note>
Rgb emission_along(const PathContext& context, const Path& path, bool escaped, const LobeShares* shares,
                   const Note& note) {
  const auto weigh = [&path](float light_pdf, float distance) {
    return path.through_media(Rgb(mis_weight(path, light_pdf)), distance - path.straight);
  };
  Rgb light(0.0f);
  path.lights->each_emitted(ray_from_vertex(path), escaped, path.depth == 0, path.light_context, weigh, path.straight,
                            shares, [&](size_t i, const Rgb& term) { light += term, note(i, term); });
  light = path.throughput * light;
  if (path.lights->has_shadow_links() && path.from_vertex) [[unlikely]]
    light += path.throughput * linked_light_emission(context, path, escaped, shares, note);
  return light;
}

Rgb emission_along(const PathContext& context, const Path& path, bool escaped, const LobeShares* shares) {
  const auto add_to_group = [&path](size_t light, const Rgb& term) {
    path.add_to_group(path.lights->group_of(light), path.throughput * term);
  };
  return path.light_groups ? emission_along(context, path, escaped, shares, add_to_group)
                           : emission_along(context, path, escaped, shares, [](size_t, const Rgb&) {});
}

}  // namespace

Rgb meet_lights(const PathContext& context, bool escaped, Path* path) {
  if (!context.scene.features.lobe_scales || path->depth == 0) [[likely]] {
    const Rgb light = emission_along(context, *path, escaped, nullptr);
    path->add(light);
    return light;
  }
  const Rgb& share = path->specular_share;
  if (!path->splits_by_lobes()) {
    const LobeShares both{Rgb(1.0f) - share, share};
    const Rgb light = emission_along(context, *path, escaped, &both);
    path->add(light);
    return light;
  }
  const LobeShares by_diffuse{Rgb(1.0f) - share, Rgb(0.0f)}, by_specular{Rgb(0.0f), share};
  const Rgb diffuse = emission_along(context, *path, escaped, &by_diffuse),
            specular = emission_along(context, *path, escaped, &by_specular);
  path->add_by_lobes(diffuse, specular);
  return diffuse + specular;
}

Rgb surface_emission(const Vertex& v, const Path& path) {
  if (is_black(v.material.emission)) return Rgb(0.0f);
  float weight = 1;
  if (path.pdf > 0) {
    const Ray ray = ray_from_vertex(path);
    weight = mis_weight(
        path, path.lights->mesh_light_pdf(ray, path.straight + v.triangle.t, v.triangle.instance, v.triangle.triangle));
  }
  return path.throughput * v.material.emission * weight;
}

}  // namespace alabaster
