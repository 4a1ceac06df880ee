#include "core/integrator/camera_interiors.h"

#include <algorithm>
#include <cmath>

#include "core/diagnostics/cancel.h"
#include "core/integrator/boundary.h"
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

using MayGoOn = std::function<bool()>;

bool crosses(const Mesh& mesh, const Affine& object_to_render, const Bounds& region, const MayGoOn& may_go_on) {
  constexpr size_t kStretch = 1 << 16;  // triangles: about a millisecond
  const size_t count = mesh.triangles.size();
  for (size_t begin = 0; begin < count; begin += kStretch) {
    if (!may_go_on()) throw BuildCancelled();
    const auto first = mesh.triangles.begin() + std::ptrdiff_t(begin);
    if (std::any_of(first, first + std::ptrdiff_t(std::min(kStretch, count - begin)), [&](const Corners& corners) {
          Bounds triangle;
          for (const uint32_t corner : corners) triangle.extend(object_to_render.point(mesh.points[corner]));
          return overlap(triangle, region);
        }))
      return true;
  }
  return false;
}

// Looks for clear bodies at the origins of rays.
class Search {
 public:
  Search(const SceneSnapshot& scene, const Bounds& origins, const MayGoOn& may_go_on)
      : scene_(scene), origins_(origins), may_go_on_(may_go_on) {}

  Surroundings run() {
    if (!overlap(scene_.clear_bodies, origins_)) return found_;
    for (const Instance& instance : scene_.instances)
      if (has_clear_interior(instance))
        add(instance.prototype->mesh, instance.object_to_world, !instance.is_still());
    for (const InstanceArray& array : scene_.arrays)
      if (has_clear_interior(array.look)) add_array(array);
    return found_;
  }

 private:
  // Adds a body that stands at `object_to_render`, and moves if `moves`.
  void add(const Mesh& mesh, const Affine& object_to_render, bool moves) {
    Bounds box;
    for (const Vec3f& corner : mesh.bounds.corners()) box.extend(object_to_render.point(corner));
    if (!moves && !overlap(box, origins_)) return;
    found_.near = true;
    found_.mixed = found_.mixed || moves || !mesh.closed ||
                   (!is_point(origins_) && crosses(mesh, object_to_render, origins_, may_go_on_));
  }

  void add_array(const InstanceArray& array) {
    const ArrayPlan& plan = array.placed->plan;
    for (size_t block = 0; block < plan.blocks.size() && !found_.mixed; ++block) {
      const BoundsDouble& world = plan.blocks[block]->bounds;
      Bounds box;
      if (world.empty()) continue;
      box.extend(Vec3f(world.lower - scene_.origin));
      box.extend(Vec3f(world.upper - scene_.origin));
      if (!overlap(box, origins_)) continue;
      const size_t begin = block * ArrayBlock::kSize, end = std::min(begin + ArrayBlock::kSize, plan.places->size());
      for (size_t i = begin; i < end; ++i)
        if (const auto place = plan.places->at(i))
          add(array.look.prototype->mesh, to_affine(moved_to(*place, scene_.origin)), !array.look.is_still());
    }
  }

  const SceneSnapshot& scene_;
  const Bounds& origins_;
  const MayGoOn& may_go_on_;
  Surroundings found_;
};

// The interiors that rays in all directions find at a point. Empty: they do not agree.
std::optional<Interiors> agreed_at(const PathContext& context, const Vec3f& p) {
  constexpr int kProbes = 64;
  std::optional<Interiors> agreed;
  for (int i = 0; i < kProbes; ++i) {
    // A Fibonacci lattice on the sphere.
    const float z = 1 - (2 * static_cast<float>(i) + 1) / kProbes, phi = static_cast<float>(i) * 2.3999632f;
    const float r = std::sqrt(1 - z * z);
    const Ray ray{p, {r * std::cos(phi), r * std::sin(phi), z}};
    const Interiors found = interiors_at(context, ray, Seeker::camera);
    if (agreed && !agreed->agrees_with(found)) return std::nullopt;
    if (!agreed) agreed = found;
  }
  return agreed;
}

}  // namespace

std::unique_ptr<const CameraInteriors> CameraInteriors::find(const PathContext& context, const Bounds& origins,
                                                             const std::function<bool()>& may_go_on) {
  const Surroundings surroundings = Search(context.scene, origins, may_go_on).run();
  if (!surroundings.near) return nullptr;
  auto found = std::make_unique<CameraInteriors>();
  if (!surroundings.mixed) found->same_ = agreed_at(context, origins.center());
  if (found->same_ && found->same_->empty()) return nullptr;
  return found;
}

Interiors CameraInteriors::of(const PathContext& context, const Ray& ray) const {
  if (same_) return *same_;
  return context.scene.clear_bodies.contains(ray.org) ? interiors_at(context, ray, Seeker::camera) : Interiors();
}

}  // namespace alabaster
