#include "core/integrator/first_hit.h"

#include <algorithm>
#include <functional>

#include "core/integrator/hit_vectors.h"
#include "core/material/disney_bsdf.h"

namespace alabaster {
namespace {

// -1: it has none.
int32_t material_number(const MaterialNumbers::element_type& numbers, const DisneyMaterial& material) {
  const auto is_before = [](const auto& one, const DisneyMaterial* wanted) { return std::less<>()(one.first, wanted); };
  const auto found = std::lower_bound(numbers.begin(), numbers.end(), &material, is_before);
  return found != numbers.end() && found->first == &material ? found->second : -1;
}

}  // namespace

void record_first_hit(const PathContext& context, const Vertex& v, float distance, FilmSample* out) {
  out->alpha = 1;
  if (!(context.aovs & (kClosestAovs | kIdsAovs))) return;
  out->prim_id = v.instance->prim_id;
  if (context.materials) [[unlikely]]
    out->material_id = material_number(*context.materials, v.instance->material(v.triangle.triangle));
  if (!(context.aovs & kClosestAovs)) return;
  out->distance = distance;
  out->camera_depth = context.camera.axial_depth(v.hit.p);
  out->depth = context.camera.clip_depth(out->camera_depth);
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
