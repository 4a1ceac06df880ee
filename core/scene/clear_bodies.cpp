#include "core/scene/clear_bodies.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <memory_resource>
#include <numeric>

#include "core/scene/world_placement.h"

namespace alabaster {

bool has_clear_interior(const Instance& instance) {
  return std::any_of(instance.materials.begin(), instance.materials.end(),
                     [](const DisneyMaterial* m) { return m->transmits() && !m->constants.thin; });
}

bool has_clear_sheets(const Instance& instance) {
  return std::any_of(instance.materials.begin(), instance.materials.end(),
                     [](const DisneyMaterial* m) { return m->constants.thin && m->constants.spec_trans > 0; });
}

namespace {

bool is_opaque_somewhere(const Instance& instance) {
  return std::any_of(instance.materials.begin(), instance.materials.end(),
                     [](const DisneyMaterial* m) { return !m->transmits(); });
}

std::vector<Bounds> boxes_of_opaque_surfaces(const SceneSnapshot& snapshot) {
  std::vector<Bounds> boxes;
  for (const Instance& instance : snapshot.instances)
    if (is_opaque_somewhere(instance)) boxes.push_back(bounds_in_render_space(instance));
  for (const InstanceArray& array : snapshot.arrays)
    if (is_opaque_somewhere(array.look)) boxes.push_back(array.placed->bounds());
  boxes.erase(std::remove_if(boxes.begin(), boxes.end(), [](const Bounds& b) { return b.empty(); }), boxes.end());
  return boxes;
}

bool light_walks_in(const Instance& instance) {
  return has_clear_interior(instance) && std::any_of(instance.materials.begin(), instance.materials.end(),
                                                     [](const DisneyMaterial* m) { return m->scatters(); });
}

bool contains(const Bounds& outer, const Bounds& inner) {
  return outer.contains(inner.lower) && outer.contains(inner.upper);
}

// True if a shell of `outer`, whose mesh is closed, has the point inside (render space).
bool is_inside(const Instance& outer, const Vec3f& p, std::pmr::vector<TriangleHit>* hits) {
  const Ray ray{outer.world_to_object.point(p), normalize(Vec3f(0.36f, 0.48f, 0.8f))};
  outer.prototype->object->intersect_all(ray, hits);
  int entered = 0;
  for (const TriangleHit& hit : *hits) entered += dot(hit.normal, ray.dir) > 0 ? 1 : -1;
  return entered != 0;
}

// The bodies that light walks in, and which others lie within one of them.
class WalkedIn {
 public:
  explicit WalkedIn(const SceneSnapshot& snapshot) {
    std::vector<Bounds> boxes;
    for (const Instance& instance : snapshot.instances) {
      const bool may_hold = light_walks_in(instance) && instance.prototype->mesh.closed;
      const Bounds box = may_hold ? bounds_in_render_space(instance) : Bounds();
      if (box.empty()) continue;
      boxes.push_back(box);
      instances_.push_back(&instance);
    }
    boxes_ = BoxTree(std::move(boxes));
  }

  /// True if one of them has all these points inside.
  bool contain(const std::vector<Vec3f>& points) const {
    Bounds box;
    for (const Vec3f& p : points) box.extend(p);
    bool found = false;
    std::pmr::vector<TriangleHit> hits;
    boxes_.search([&](const Bounds& b) { return !found && contains(b, box); },
                  [&](uint32_t i) {
                    found = std::all_of(points.begin(), points.end(),
                                        [&](const Vec3f& p) { return is_inside(*instances_[i], p, &hits); });
                  });
    return found;
  }

 private:
  std::vector<const Instance*> instances_;
  BoxTree boxes_{{}};
};

// About `most` of `all`, evenly.
template <class T, class F>
void for_some(const std::vector<T>& all, size_t most, const F& f) {
  for (size_t i = 0; i < all.size(); i += std::max<size_t>(1, all.size() / most)) f(all[i]);
}

// Empty: they share no point.
Bounds common(const Bounds& a, const Bounds& b) {
  Bounds both;
  for (int axis = 0; axis < 3; ++axis) {
    both.lower[axis] = std::max(a.lower[axis], b.lower[axis]);
    both.upper[axis] = std::min(a.upper[axis], b.upper[axis]);
  }
  return both;
}

}  // namespace

void rank_clear_bodies(SceneSnapshot* snapshot) {
  constexpr size_t kPoints = 32;
  const WalkedIn walked_in(*snapshot);
  // Below the eight bits of the priority.
  const auto rank = [](bool scatters, bool within_one) {
    return uint32_t(scatters || within_one) << 23 | uint32_t(within_one) << 22;
  };
  for (Instance& instance : snapshot->instances) {
    if (!has_clear_interior(instance)) continue;
    const bool scatters = light_walks_in(instance);
    std::vector<Vec3f> points;
    if (!scatters)
      for_some(instance.prototype->mesh.points, kPoints,
               [&](const Vec3f& p) { points.push_back(instance.object_to_world.point(p)); });
    instance.clear_rank = rank(scatters, !points.empty() && walked_in.contain(points));
  }
  for (InstanceArray& array : snapshot->arrays) {
    if (!has_clear_interior(array.look)) continue;
    const bool scatters = light_walks_in(array.look);
    std::vector<Vec3f> points;
    const InstancePlaces& places = *array.placed->plan.places;
    for (size_t i = 0; !scatters && i < places.size(); i += std::max<size_t>(1, places.size() / kPoints))
      if (const auto place = places.at(i))
        for (const Vec3f& corner : array.look.prototype->mesh.bounds.corners())
          points.push_back(to_affine(moved_to(*place, snapshot->origin)).point(corner));
    array.look.clear_rank = rank(scatters, !points.empty() && walked_in.contain(points));
  }
}

uint64_t interior_priority(const Instance& instance, const Placement& placement, uint32_t priority, uint32_t index) {
  // Of the mesh's box in its own space: a scene that is turned as a whole keeps its order.
  const Affine& m = placement.object_to_world;
  const Vec3f e = instance.prototype->mesh.bounds.extent();
  const float volume = e.x * e.y * e.z * std::abs(dot(m.x, cross(m.y, m.z)));
  const uint32_t smallness = 0x3fff - (std::bit_cast<uint32_t>(volume) >> 17);  // 14 bits
  return uint64_t(instance.clear_rank | priority << 24 | smallness << 8) << 32 | index;
}

Bounds bounds_in_render_space(const Instance& instance) {
  Bounds bounds;
  for (const Vec3f& corner : instance.prototype->mesh.bounds.corners()) {
    bounds.extend(instance.object_to_world.point(corner));
    for (const Affine& pose : instance.poses) bounds.extend(pose.point(corner));
  }
  return bounds;
}

Bounds wider(const Bounds& box) {
  const Vec3f by(0x1p-16f * std::max(max_abs_component(box.lower), max_abs_component(box.upper)));
  return {box.lower - by, box.upper + by};
}

ClearBoxes::ClearBoxes(const SceneSnapshot& snapshot) {
  std::vector<Bounds> boxes;
  const auto add = [&](const Bounds& box, uint32_t instance) {
    if (box.empty()) return;
    boxes.push_back(box);
    instances_.push_back(instance);
  };
  for (uint32_t i = 0; i < snapshot.instances.size(); ++i)
    if (has_clear_interior(snapshot.instances[i])) add(bounds_in_render_space(snapshot.instances[i]), i);
  for (const InstanceArray& array : snapshot.arrays)
    if (has_clear_interior(array.look)) add(array.placed->bounds(), kNone);
  boxes_ = BoxTree(std::move(boxes));
  if (instances_.empty()) return;
  std::vector<Bounds> opaque = boxes_of_opaque_surfaces(snapshot);
  for (Bounds& box : opaque) box = wider(box);
  opaque_ = BoxTree(std::move(opaque));
}

Bounds ClearBoxes::that_meet(const Bounds& box, const std::vector<uint32_t>& left_out) const {
  Bounds all;
  const Bounds touching = wider(box);
  boxes_.search([&](const Bounds& b) { return overlap(b, touching) && !contains(all, b); },
                [&](uint32_t i) {
                  if (!std::binary_search(left_out.begin(), left_out.end(), instances_[i])) all.extend(boxes_[i]);
                });
  return all;
}

Bounds ClearBoxes::meetings() const {
  Bounds all;
  std::vector<Bounds> boxes;
  for (uint32_t i = 0; i < boxes_.size(); ++i) {
    boxes.push_back(wider(boxes_[i]));
    if (instances_[i] == kNone) all.extend(boxes.back());  // its bodies may touch each other
  }
  const BoxTree wide(std::move(boxes));
  extend_by_meetings(wide, wide, &all);
  extend_by_meetings(wide, opaque_, &all);
  return all;
}

// Large boxes come first: their common parts often hold those of the small ones.
size_t extend_by_meetings(const BoxTree& boxes, const BoxTree& others, Bounds* all) {
  std::vector<uint32_t> order(boxes.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto size = [&](uint32_t i) { return length(boxes[i].extent()); };
  std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return size(a) > size(b); });
  size_t compared = 0;
  for (const uint32_t i : order) {
    const Bounds& box = boxes[i];
    if (contains(*all, box)) continue;
    others.search(
        [&](const Bounds& b) {
          ++compared;
          const Bounds both = common(b, box);
          return !both.empty() && !contains(*all, both);
        },
        [&](uint32_t k) {
          if (&others != &boxes || k != i) all->extend(common(others[k], box));
        });
  }
  return compared;
}

}  // namespace alabaster
