#include "core/scene/clear_bodies.h"

#include <algorithm>

namespace alabaster {

bool has_clear_interior(const Instance& instance) {
  return std::any_of(instance.materials.begin(), instance.materials.end(),
                     [](const DisneyMaterial* m) { return m->transmits() && !m->constants.thin; });
}

Bounds bounds_in_render_space(const Instance& instance) {
  Bounds bounds;
  for (const Vec3f& corner : instance.prototype->mesh.bounds.corners()) {
    bounds.extend(instance.object_to_world.point(corner));
    for (const Affine& pose : instance.poses) bounds.extend(pose.point(corner));
  }
  return bounds;
}

bool overlap(const Bounds& a, const Bounds& b) {
  for (int i = 0; i < 3; ++i)
    if (a.lower[i] > b.upper[i] || b.lower[i] > a.upper[i]) return false;
  return true;
}

ClearBoxes::ClearBoxes(const SceneSnapshot& snapshot) {
  constexpr size_t kMost = 1024;  // each body is compared with each box
  for (uint32_t i = 0; i < snapshot.instances.size(); ++i)
    if (has_clear_interior(snapshot.instances[i])) boxes_.push_back({bounds_in_render_space(snapshot.instances[i]), i});
  for (const InstanceArray& array : snapshot.arrays)
    if (has_clear_interior(array.look)) boxes_.push_back({array.placed->bounds(), kNone});
  if (boxes_.size() > kMost) boxes_.assign(1, {snapshot.clear_bodies, kNone});
}

Bounds ClearBoxes::that_meet(const Bounds& box, const std::vector<uint32_t>& left_out) const {
  Bounds all;
  for (const Box& clear : boxes_) {
    if (!overlap(clear.bounds, box)) continue;
    if (std::find(left_out.begin(), left_out.end(), clear.instance) != left_out.end()) continue;
    all.extend(clear.bounds);
  }
  return all;
}

}  // namespace alabaster
