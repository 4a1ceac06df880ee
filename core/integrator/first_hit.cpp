#include "core/integrator/first_hit.h"

#include <algorithm>
#include <functional>

#include "core/integrator/hit_vectors.h"
#include "core/integrator/see_through.h"
#include "core/material/disney_bsdf.h"
#include "core/sampling/warp.h"

namespace alabaster {
namespace {

// -1: it has none.
int32_t material_number(const MaterialNumbers::element_type& numbers, const DisneyMaterial& material) {
  const auto is_before = [](const auto& one, const DisneyMaterial* wanted) { return std::less<>()(one.first, wanted); };
  const auto found = std::lower_bound(numbers.begin(), numbers.end(), &material, is_before);
  return found != numbers.end() && found->first == &material ? found->second : -1;
}

int32_t matte_of(const InstanceMattes::element_type& mattes, const Vertex& v) {
  const int32_t first = mattes[static_cast<size_t>(v.instance->prim_id)];
  return first < 0 ? v.instance->prim_id : first + v.instance->id_of(v.triangle);
}

// 1 where one direction above the smooth surface, by the cosine, meets nothing within the distance. What shadow rays
// pass does not occlude either. The ray is no part of the path, nor of what a pixel costs: samples and their allocation
// are those of a frame without it.
float ambient_occlusion(const PathContext& context, const Vertex& v, const Path& path, const PixelSampler& sampler) {
  const auto u = sampler.draw(Dimension::ambient_occlusion, 0);
  const Vec3f dir = frame_from_normal(v.smooth_normal()).to_world(sample_cosine_hemisphere({u[0], u[1]}));
  const bool from_smooth = v.leaves_from_smooth(dir);
  if (!from_smooth && !v.is_above_facet(dir)) return 0;
  Ray ray{v.origins[from_smooth ? Vertex::kSmooth : Vertex::kFacet].p, dir};
  ray.time = context.time;
  if (context.settings.ambient_occlusion_distance > 0) ray.tmax = context.settings.ambient_occlusion_distance;
  if (!context.sees_through() && !context.scene.features.clear_sheets) return context.scene.top->occluded(ray) ? 0 : 1;
  const Transmittance transmittance(context, ray.dir, path.media);
  if (context.scene.top->occluded(ray, &transmittance)) return 0;
  const Rgb passed = transmittance.value();
  return (passed.r + passed.g + passed.b) / 3;
}

}  // namespace

void record_first_hit(const PathContext& context, const Vertex& v, const Path& path, const PixelSampler& sampler,
                      float distance, FilmSample* out) {
  out->alpha = 1;
  if (context.aovs & aov_bit(Aov::ambient_occlusion)) [[unlikely]]
    out->ambient_occlusion = ambient_occlusion(context, v, path, sampler);
  if (!(context.aovs & (kClosestAovs | kIdsAovs))) return;
  out->prim_id = out->matte = v.instance->prim_id;
  if (context.mattes) [[unlikely]]
    out->matte = matte_of(*context.mattes, v);
  if (context.materials) [[unlikely]]
    out->material_id = material_number(*context.materials, v.instance->material(v.triangle.triangle));
  if (!(context.aovs & kClosestAovs)) return;
  out->distance = distance;
  out->camera_depth = context.camera.axial_depth(v.hit.p);
  out->depth = context.camera.clip_depth(out->camera_depth);
  if (context.aovs & aov_bit(Aov::camera_distance)) out->camera_distance = context.camera.distance(v.hit.p);
  out->instance_id = v.instance->id_of(v.triangle);
  out->element_id = v.instance->prototype->mesh.element(v.triangle.triangle);
  if (context.vectors) [[unlikely]]
    record_hit_vectors(context, v, out);
}

void record_features(const PathContext& context, const Vertex& v, const Path& path) {
  if (context.aovs & aov_bit(Aov::normal)) path.features->normal = v.frame.n;
  if (context.aovs & aov_bit(Aov::albedo))
    path.features->albedo = DisneyBsdf(v.material, {0, 0, 1}).albedo() * clamp01(path.throughput);
}

bool is_mirror(const Vertex& v, Lobe lobe) {
  constexpr float kLargestRoughness = 0.1f;
  if (lobe == Lobe::straight) return true;
  return (lobe == Lobe::specular || lobe == Lobe::dielectric) && v.material.roughness <= kLargestRoughness;
}

}  // namespace alabaster
