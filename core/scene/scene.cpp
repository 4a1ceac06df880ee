#include "core/scene/scene.h"

#include <algorithm>
#include <iterator>

namespace alabaster {

std::optional<InstanceDescription> InstanceArrayDescription::instance(size_t number) const {
  const auto place = places->at(number);
  if (!place) return std::nullopt;
  InstanceDescription one = look;
  one.object_to_world = *place;
  one.instance_id = static_cast<int32_t>(number);
  return one;
}

bool InstanceArrayDescription::operator==(const InstanceArrayDescription& other) const {
  return look == other.look && places->size() == other.places->size() &&
         places->stand_alike(*other.places, 0, places->size());
}

const Placement& Instance::place(const TriangleHit& hit, std::optional<Placement>* moved) const {
  if (array) return moved->emplace(array->placed->traced.placement(hit.instance - array->first));
  const Affine map = posed(poses, hit.time);
  return moved->emplace(Placement{map, inverse(map)});
}

int32_t Instance::id_of(const TriangleHit& hit) const {
  return array ? static_cast<int32_t>(hit.instance - array->first) : instance_id;
}

const Instance& SceneSnapshot::look(uint32_t index) const {
  const auto after = std::upper_bound(arrays.begin(), arrays.end(), index,
                                      [](uint32_t i, const InstanceArray& a) { return i < a.first; });
  return std::prev(after)->look;
}

size_t SceneSnapshot::instance_count() const {
  return arrays.empty() ? instances.size() : arrays.back().first + arrays.back().placed->size();
}

bool is_behind(const Instance& instance, const TriangleHit& hit, const Vec3f& dir) {
  if (instance.stands_alone() && !instance.prototype->mesh.deforms()) [[likely]] {
    const Mesh& mesh = instance.prototype->mesh;
    const Corners& c = mesh.triangles[hit.triangle];
    const Vec3f n = cross(mesh.points[c[1]] - mesh.points[c[0]], mesh.points[c[2]] - mesh.points[c[0]]);
    return dot(n, instance.world_to_object.vector(dir)) > 0;
  }
  const auto [p0, p1, p2] = instance.prototype->mesh.corners_at(hit.triangle, hit.time);
  std::optional<Placement> moved;
  return dot(cross(p1 - p0, p2 - p0), instance.at(hit, &moved).world_to_object.vector(dir)) > 0;
}

std::vector<size_t> used_slots(const InstanceDescription& instance, bool (*is_such)(const DisneyMaterial&)) {
  const auto& materials = instance.materials;
  std::vector<size_t> found;
  if (std::none_of(materials.begin(), materials.end(), [&](const auto& m) { return is_such(*m); })) return found;
  const TriangleSlots& slots = instance.triangle_slots();
  std::vector<bool> used(materials.size(), false);
  if (slots.empty()) used[0] = true;
  for (const int32_t slot : slots) used[static_cast<size_t>(slot) < used.size() ? static_cast<size_t>(slot) : 0] = true;
  for (size_t slot = 0; slot < used.size(); ++slot)
    if (used[slot] && is_such(*materials[slot])) found.push_back(slot);
  return found;
}

std::vector<size_t> scattering_slots(const InstanceDescription& instance) {
  return used_slots(instance, [](const DisneyMaterial& material) { return material.scatters(); });
}

}  // namespace alabaster
