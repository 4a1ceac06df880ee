#include "core/integrator/camera_interiors.h"

#include <algorithm>
#include <cmath>

#include "core/diagnostics/cancel.h"
#include "core/integrator/interface.h"
#include "core/scene/clear_bodies.h"
#include "core/scene/world_placement.h"

namespace alabaster {
namespace {

// Clear bodies at the origins of the camera's rays.
struct Surroundings {
  bool near = false;   // the box of one meets the origins
  bool mixed = false;  // rays may begin in different interiors: a surface may pass between their origins, or is open
};

bool is_point(const Bounds& bounds) {
  return bounds.lower == bounds.upper;
}

// The origins of the camera's rays. The search among many triangles and instances may be cancelled.
struct Origins {
  const Bounds& bounds;
  const CancelToken& cancel;
};

bool crosses(const Mesh& mesh, const Affine& object_to_render, const Origins& origins) {
  size_t count = 0;
  return std::any_of(mesh.triangles.begin(), mesh.triangles.end(), [&](const Corners& corners) {
    if (++count % 4096 == 0) origins.cancel.check();
    Bounds triangle;
    for (const uint32_t corner : corners) triangle.extend(object_to_render.point(mesh.points[corner]));
    return overlap(triangle, origins.bounds);
  });
}

// Adds a body that stands at `object_to_render`, and moves if `moves`.
void add(const Mesh& mesh, const Affine& object_to_render, bool moves, const Origins& origins, Surroundings* found) {
  origins.cancel.check();
  Bounds box;
  for (const Vec3f& corner : mesh.bounds.corners()) box.extend(object_to_render.point(corner));
  if (!moves && !overlap(box, origins.bounds)) return;
  found->near = true;
  found->mixed =
      found->mixed || moves || !mesh.closed || (!is_point(origins.bounds) && crosses(mesh, object_to_render, origins));
}

void add_array(const SceneSnapshot& scene, const InstanceArray& array, const Origins& origins, Surroundings* found) {
  const ArrayPlan& plan = array.placed->plan;
  for (size_t block = 0; block < plan.blocks.size() && !found->mixed; ++block) {
    const BoundsDouble& world = plan.blocks[block]->bounds;
    Bounds box;
    if (world.empty()) continue;
    box.extend(Vec3f(world.lower - scene.origin));
    box.extend(Vec3f(world.upper - scene.origin));
    if (!overlap(box, origins.bounds)) continue;
    const size_t begin = block * ArrayBlock::kSize, end = std::min(begin + ArrayBlock::kSize, plan.places->size());
    for (size_t i = begin; i < end; ++i)
      if (const auto place = plan.places->at(i))
        add(array.look.prototype->mesh, to_affine(moved_to(*place, scene.origin)), !array.look.is_still(), origins,
            found);
  }
}

Surroundings surroundings_of(const SceneSnapshot& scene, const Origins& origins) {
  Surroundings found;
  if (!overlap(scene.clear_bodies, origins.bounds)) return found;
  for (const Instance& instance : scene.instances)
    if (has_clear_interior(instance))
      add(instance.prototype->mesh, instance.object_to_world, !instance.is_still(), origins, &found);
  for (const InstanceArray& array : scene.arrays)
    if (has_clear_interior(array.look)) add_array(scene, array, origins, &found);
  return found;
}

// The interiors that rays in all directions find at a point. Empty: they do not agree.
std::optional<MediumStack> agreed_at(const PathContext& context, const Vec3f& p) {
  constexpr int kProbes = 64;
  std::optional<MediumStack> agreed;
  for (int i = 0; i < kProbes; ++i) {
    // A Fibonacci lattice on the sphere.
    const float z = 1 - (2 * static_cast<float>(i) + 1) / kProbes, phi = static_cast<float>(i) * 2.3999632f;
    const float r = std::sqrt(1 - z * z);
    const Ray ray{p, {r * std::cos(phi), r * std::sin(phi), z}};
    const MediumStack found = interiors_at(context, ray, Seeker::camera);
    if (agreed && !agreed->agrees_with(found)) return std::nullopt;
    if (!agreed) agreed = found;
  }
  return agreed;
}

}  // namespace

bool begin_behind_fronts(const SceneSnapshot& scene, const Bounds& origins) {
  const auto is_behind = [&](const Instance& i) {
    if (!i.single_sided) return false;
    if (is_point(origins) && i.is_still())  // of many instances that is quicker
      return i.prototype->mesh.bounds.contains(i.world_to_object.point(origins.lower));
    return overlap(bounds_in_render_space(i), origins);
  };
  return std::any_of(scene.instances.begin(), scene.instances.end(), is_behind) ||
         std::any_of(scene.arrays.begin(), scene.arrays.end(), [&](const InstanceArray& array) {
           return array.look.single_sided && overlap(array.placed->bounds(), origins);
         });
}

std::unique_ptr<const CameraInteriors> CameraInteriors::find(const PathContext& context, const Bounds& origins) {
  const Surroundings surroundings = surroundings_of(context.scene, {origins, context.settings.walk.cancel});
  if (!surroundings.near) return nullptr;
  auto found = std::make_unique<CameraInteriors>();
  if (!surroundings.mixed) found->same_ = agreed_at(context, origins.center());
  if (found->same_ && found->same_->empty()) return nullptr;
  return found;
}

MediumStack CameraInteriors::of(const PathContext& context, const Ray& ray) const {
  if (same_) return *same_;
  return context.scene.clear_bodies.contains(ray.org) ? interiors_at(context, ray, Seeker::camera) : MediumStack();
}

}  // namespace alabaster
