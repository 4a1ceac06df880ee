#include "core/scene/scene.h"

#include <algorithm>

namespace alabaster {

const Placement& Instance::move_to(float time, std::optional<Placement>* moved) const {
  const Affine map = posed(poses, time);
  return moved->emplace(Placement{map, inverse(map)});
}

bool is_behind(const Instance& instance, const TriangleHit& hit, const Vec3f& dir) {
  if (instance.is_still()) [[likely]] {
    const Mesh& mesh = instance.prototype->mesh;
    const Corners& c = mesh.triangles[hit.triangle];
    const Vec3f n = cross(mesh.points[c[1]] - mesh.points[c[0]], mesh.points[c[2]] - mesh.points[c[0]]);
    return dot(n, instance.world_to_object.vector(dir)) > 0;
  }
  const auto [p0, p1, p2] = instance.prototype->mesh.corners_at(hit.triangle, hit.time);
  std::optional<Placement> moved;
  return dot(cross(p1 - p0, p2 - p0), instance.at(hit.time, &moved).world_to_object.vector(dir)) > 0;
}

std::vector<size_t> scattering_slots(const InstanceDescription& instance) {
  const auto& materials = instance.materials;
  std::vector<size_t> found;
  if (std::none_of(materials.begin(), materials.end(), [](const auto& m) { return m->scatters(); })) return found;
  const auto& slots = instance.prototype->mesh.triangle_material;
  std::vector<bool> used(materials.size(), false);
  if (slots.empty()) used[0] = true;
  for (const int32_t slot : slots) used[static_cast<size_t>(slot) < used.size() ? static_cast<size_t>(slot) : 0] = true;
  for (size_t slot = 0; slot < used.size(); ++slot)
    if (used[slot] && materials[slot]->scatters()) found.push_back(slot);
  return found;
}

}  // namespace alabaster
