#include "core/scene/missing_tiles.h"

#include "core/geometry/surface_hit.h"

namespace alabaster {
namespace {

// The first middle of a triangle for which the lookup's set of images has none.
std::optional<Vec2f> find_missing_tile(const Instance& instance, const DisneyMaterial* material,
                                       const TextureLookup& lookup) {
  if (!lookup.image || !lookup.image->is_set()) return std::nullopt;
  Vec4f by_instance(0);  // such coordinates take the place of the mesh's, and are not looked at here
  if (instance.values && instance.values->read(lookup.primvar, static_cast<size_t>(instance.instance_id), &by_instance))
    return std::nullopt;
  const Mesh& mesh = instance.prototype->mesh;
  const UvSet* const set = mesh.uv_set(lookup.primvar);
  for (uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    if (&instance.material(i) != material) continue;
    TriangleHit middle;
    middle.triangle = i, middle.u = middle.v = 1.0f / 3;
    const Vec2f uv = lookup.transform(set ? interpolated<Vec2f>(*set, mesh, middle) : Vec2f(0, 0));
    if (!lookup.image->covers(uv)) return uv;
  }
  return std::nullopt;
}

}  // namespace

void MissingTiles::find(const InstanceDescription& d, const Instance& instance) {
  for (const auto& material : d.materials) {
    if (!seen_.insert({instance.prototype, instance.slots, material.get()}).second) continue;
    for (const MaterialTexture& texture : material->textures) find(d, instance, material.get(), texture.lookup);
    for (const auto* map : {&material->normal_map, &material->coat_normal_map})
      if (*map) find(d, instance, material.get(), **map);
  }
}

void MissingTiles::find(const InstanceDescription& d, const Instance& instance, const DisneyMaterial* material,
                        const TextureLookup& lookup) {
  const auto uv = find_missing_tile(instance, material, lookup);
  if (!uv) return;
  faults_->push_back(d.name + ": a set of images has none at (" + std::to_string(uv->x) + ", " + std::to_string(uv->y) +
                     ")");
  report(sink_, Severity::error, "texture.tile", d.name, faults_->back());
}

}  // namespace alabaster
