#include "core/scene/clear_bodies.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace alabaster {

bool has_clear_interior(const Instance& instance) {
  return std::any_of(instance.materials.begin(), instance.materials.end(),
                     [](const DisneyMaterial* m) { return m->transmits() && !m->constants.thin; });
}

namespace {

// In [0, 2^14): larger for smaller ones.
uint32_t smallness(float volume) {
  return 0x3fff - (std::bit_cast<uint32_t>(volume) >> 17);
}

// The volume of the mesh's box in its own space: a scene that is turned as a whole keeps its order.
float volume_of_box(const Mesh& mesh) {
  const Vec3f e = mesh.bounds.extent();
  return e.x * e.y * e.z;
}

float volume_of_box(const Instance& instance) {
  const Affine& m = instance.object_to_world;
  return volume_of_box(instance.prototype->mesh) * std::abs(dot(m.x, cross(m.y, m.z)));
}

// Bit 31, below it the eight of the priority, then bit 22; the last eight are left to tell alike bodies apart.
uint32_t rank(bool scatters, bool within_one, float volume) {
  return uint32_t(scatters || within_one) << 31 | uint32_t(within_one) << 22 | smallness(volume) << 8;
}

bool light_walks_in(const Instance& instance) {
  return has_clear_interior(instance) && std::any_of(instance.materials.begin(), instance.materials.end(),
                                                     [](const DisneyMaterial* m) { return m->scatters(); });
}

}  // namespace

void rank_clear_bodies(SceneSnapshot* snapshot) {
  constexpr size_t kMost = 1024;  // each clear body is compared with each of these
  std::vector<Bounds> walked_in;
  for (const Instance& instance : snapshot->instances)
    if (light_walks_in(instance)) walked_in.push_back(bounds_in_render_space(instance));
  if (walked_in.size() > kMost) walked_in.clear();
  for (Instance& instance : snapshot->instances) {
    if (!has_clear_interior(instance)) continue;
    const Bounds box = bounds_in_render_space(instance);
    const bool scatters = light_walks_in(instance);
    const bool within_one = !scatters && std::any_of(walked_in.begin(), walked_in.end(), [&](const Bounds& b) {
      return b.contains(box.lower) && b.contains(box.upper);
    });
    instance.clear_rank = rank(scatters, within_one, volume_of_box(instance));
  }
  for (InstanceArray& array : snapshot->arrays) {
    if (!has_clear_interior(array.look)) continue;
    const float stretch = array.placed->plan.least_stretch();
    array.look.clear_rank = rank(light_walks_in(array.look), false,
                                 volume_of_box(array.look.prototype->mesh) * stretch * stretch * stretch);
  }
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

Bounds ClearBoxes::meetings() const {
  // Faces that coincide but for rounding count as touching.
  const auto wider = [](const Bounds& box) {
    const Vec3f by(0x1p-16f * std::max(max_abs_component(box.lower), max_abs_component(box.upper)));
    return Bounds{box.lower - by, box.upper + by};
  };
  Bounds all;
  for (size_t i = 0; i < boxes_.size(); ++i) {
    const Bounds a = wider(boxes_[i].bounds);
    if (boxes_[i].instance == kNone) all.extend(a);  // its bodies may touch each other
    for (size_t k = i + 1; k < boxes_.size(); ++k) {
      const Bounds b = wider(boxes_[k].bounds);
      if (!overlap(a, b)) continue;
      Bounds common;
      for (int axis = 0; axis < 3; ++axis) {
        common.lower[axis] = std::max(a.lower[axis], b.lower[axis]);
        common.upper[axis] = std::min(a.upper[axis], b.upper[axis]);
      }
      all.extend(common);
    }
  }
  return all;
}

}  // namespace alabaster
