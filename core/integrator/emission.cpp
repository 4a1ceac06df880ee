#include "core/integrator/emission.h"

#include "core/integrator/see_through.h"
#include "core/sampling/mis.h"

namespace alabaster {
namespace {

float mis_weight(const Path& path, float light_pdf) {
  return path.pdf > 0 ? power_heuristic(path.pdf, light_pdf) : 1.0f;
}

Rgb linked_light_emission(const PathContext& context, const Path& path, bool escaped) {
  const auto weigh = [&path](float light_pdf) { return mis_weight(path, light_pdf); };
  const bool is_clear = escaped && !context.sees_through();
  return path.lights->emitted_with_links(
      path.ray, path.light_context, weigh, [&](uint32_t link, float distance) -> Rgb {
        const Ray ray{path.ray.org, path.ray.dir, distance, path.ray.time};
        if (is_clear) return path.through_media(Rgb(1.0f), distance);
        ++context.counters.shadow_rays;
        return path.through_media(Rgb(linked_visibility(context.scene, ray, link, &path.media)), distance);
      });
}

}  // namespace

Rgb emission_along(const PathContext& context, const Path& path, bool escaped, bool from_vertex) {
  const auto weigh = [&path](float light_pdf) { return mis_weight(path, light_pdf); };
  const auto weigh_in_media = [&](float light_pdf, float distance) {
    return path.media.transmittance(distance) * weigh(light_pdf);
  };
  const bool is_camera_ray = path.depth == 0;
  const LightSampleContext& at = path.light_context;
  Rgb light = path.throughput * (path.media.empty()
                                     ? path.lights->emitted(path.ray, escaped, is_camera_ray, at, weigh)
                                     : path.lights->emitted(path.ray, escaped, is_camera_ray, at, weigh_in_media));
  if (path.lights->has_shadow_links() && from_vertex) [[unlikely]]
    light += path.throughput * linked_light_emission(context, path, escaped);
  return light;
}

Rgb surface_emission(const Vertex& v, const Path& path) {
  if (is_black(v.material.emission)) return Rgb(0.0f);
  const TriangleHit& hit = v.triangle;
  float weight = 1;
  if (path.pdf > 0) weight = mis_weight(path, path.lights->mesh_light_pdf(path.ray, hit.t, hit.instance, hit.triangle));
  return path.throughput * v.material.emission * weight;
}

}  // namespace alabaster
