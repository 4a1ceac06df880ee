#include "core/scene/mesh_lights.h"

#include <algorithm>
#include <utility>

#include "core/sampling/warp.h"

namespace alabaster {
namespace {

// Emission at a point of a triangle, of which only a share may be there.
Rgb emission_at(const Instance& instance, uint32_t triangle, const Vec2f& b) {
  const Mesh& mesh = instance.prototype->mesh;
  TriangleHit hit;
  hit.triangle = triangle, hit.u = b.x, hit.v = b.y;
  const Vec2f uv = mesh.uv_sets.empty() ? Vec2f(0, 0) : interpolated<Vec2f>(mesh.uv_sets.front(), mesh, hit);
  const HitPrimvars at = instance.primvars_at(hit, uv);
  const DisneyMaterial& material = instance.material(triangle);
  return material.evaluate(at).emission * material.coverage(at);
}

bool has_varying_emission(const DisneyMaterial& material) {
  return material.varies(&DisneyParameters::emission) || material.is_partly_opaque();
}

// The mean over a triangle by points spread over it. Where it misses all bright texels the triangle is never chosen,
// and paths that meet it count in full.
Rgb mean_emission(const Instance& instance, uint32_t triangle) {
  const DisneyMaterial& material = instance.material(triangle);
  if (!has_varying_emission(material)) return material.constants.emission;
  const int side = instance.prototype->mesh.triangles.size() > 65536 ? 2 : 8;
  const float step = 1 / static_cast<float>(side);
  Rgb sum(0.0f);
  for (int i = 0; i < side * side; ++i) {
    const Vec2f u((static_cast<float>(i % side) + 0.5f) * step, (static_cast<float>(i / side) + 0.5f) * step);
    const Vec2f b = sample_uniform_triangle(u);
    sum += emission_at(instance, triangle, {b.y, 1 - b.x - b.y});
  }
  return sum * (step * step);
}

size_t emissive_triangles(const Instance& instance) {
  size_t count = 0;
  for (uint32_t i = 0; i < instance.prototype->mesh.triangles.size(); ++i) count += instance.material(i).emits();
  return count;
}

}  // namespace

bool emits(const Instance& instance) {
  if (std::none_of(instance.materials.begin(), instance.materials.end(), [](const auto* m) { return m->emits(); }))
    return false;
  for (uint32_t i = 0; i < instance.prototype->mesh.triangles.size(); ++i)
    if (instance.material(i).emits()) return true;
  return false;
}

MeshLight make_mesh_light(const Instance& instance, uint32_t index, const std::shared_ptr<MemoryBudget>& budget,
                          const CancelToken& cancel) {
  const Mesh& mesh = instance.prototype->mesh;
  const size_t count = emissive_triangles(instance);
  MemoryReservation memory(budget, MemoryUse::lights, MeshLight::build_bytes(count, mesh.triangles.size()),
                           "the light of a mesh of " + std::to_string(count) + " triangles that emit");
  std::vector<MeshLight::Triangle> triangles;
  std::vector<uint32_t> ids;
  bool varies = false;
  triangles.reserve(count);
  ids.reserve(count);
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    cancel.check();
    const DisneyMaterial& material = instance.material(static_cast<uint32_t>(i));
    if (!material.emits()) continue;
    const auto corner = [&](size_t c) { return instance.object_to_world.point(mesh.points[mesh.triangles[i][c]]); };
    triangles.push_back({corner(0), corner(1), corner(2), mean_emission(instance, static_cast<uint32_t>(i)),
                         instance.is_single_sided(instance.slot(static_cast<uint32_t>(i)))});
    ids.push_back(static_cast<uint32_t>(i));
    varies |= has_varying_emission(material);
  }
  // A copy, since later snapshots may share the light. They keep what it points to.
  MeshLight::Emission emission;
  if (varies) emission = [instance](uint32_t triangle, const Vec2f& b) { return emission_at(instance, triangle, b); };
  MeshLight light(index, std::move(triangles), ids, std::move(emission), cancel);
  light.hold(std::move(memory));
  return light;
}

KnownMeshLights::KnownMeshLights(const SceneSnapshot* snapshot) : snapshot_(snapshot) {
  if (!snapshot) return;
  for (const Light& light : snapshot->lights.lights())
    if (const auto* mesh = std::get_if<MeshLight>(&light))
      lights_.emplace(key(snapshot->instances[mesh->instance()]), mesh);
}

const MeshLight* KnownMeshLights::find(const Instance& instance) const {
  const auto emits_alike = [&](const Instance& other) {
    return other.prototype == instance.prototype && other.object_to_world == instance.object_to_world &&
           other.materials == instance.materials && other.slots == instance.slots &&
           other.single_sided_slots == instance.single_sided_slots && other.values == instance.values &&
           (!instance.values || other.instance_id == instance.instance_id);
  };
  const auto [first, last] = lights_.equal_range(key(instance));
  const auto found = std::find_if(
      first, last, [&](const auto& held) { return emits_alike(snapshot_->instances[held.second->instance()]); });
  return found == last ? nullptr : found->second;
}

}  // namespace alabaster
