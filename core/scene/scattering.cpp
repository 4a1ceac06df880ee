#include "core/scene/scattering.h"

#include <algorithm>
#include <map>

namespace alabaster {
namespace {

bool scatters(const Instance& instance) {
  return std::any_of(instance.materials.begin(), instance.materials.end(), [](const auto* m) { return m->scatters(); });
}

// Whatever a walk meets is the end of the medium.
bool is_simple(const MeshShells& shells) {
  return !shells.any_open && !shells.overlapping;
}

void walk_alone(Instance* instance) {
  const MeshPrototype& prototype = *instance->prototype;
  instance->walk.object = prototype.object.get();
  instance->walk.world_to_object = instance->world_to_object;
  instance->walk.bounds = prototype.mesh.bounds;
}

// The members' transforms relative to `origin`, a point of the world.
void add_member(const InstanceDescription& description, uint32_t index, const Vec3d& origin, WalkSet* set) {
  Matrix4d m = description.object_to_world;
  for (int i = 0; i < 3; ++i) m[3][i] -= origin[i];
  const MeshPrototype& prototype = *description.prototype;
  set->members.push_back({&prototype.mesh, &prototype.shells(), prototype.object.get(), to_affine(m),
                          to_affine(m.inverse()), Bounds(), index});
  WalkSet::Member& member = set->members.back();
  const Bounds& b = prototype.mesh.bounds;
  for (int corner = 0; corner < 8; ++corner)
    member.bounds.extend(member.to_set.point(
        {corner & 1 ? b.upper.x : b.lower.x, corner & 2 ? b.upper.y : b.lower.y, corner & 4 ? b.upper.z : b.lower.z}));
  set->bounds.extend(member.bounds);
}

Vec3d world_centre(const std::vector<const InstanceDescription*>& drawn, const std::vector<uint32_t>& indices) {
  const auto centre = [&](uint32_t i) {
    return transform_point(Vec3d(drawn[i]->prototype->mesh.bounds.center()), drawn[i]->object_to_world);
  };
  Vec3d lower = centre(indices.front()), upper = lower;
  for (uint32_t i : indices) {
    const Vec3d c = centre(i);
    for (int axis = 0; axis < 3; ++axis) {
      lower[axis] = std::min(lower[axis], c[axis]);
      upper[axis] = std::max(upper[axis], c[axis]);
    }
  }
  return (lower + upper) * 0.5;
}

bool walk_together(const std::vector<const InstanceDescription*>& drawn, const std::vector<uint32_t>& indices,
                   const std::shared_ptr<TraceDevice>& device, SceneSnapshot* snapshot) {
  auto set = std::make_shared<WalkSet>();
  const Vec3d origin = world_centre(drawn, indices);
  set->origin = Vec3f(origin - snapshot->origin);
  std::vector<InstancePlacement> placements;
  bool open = false;
  for (uint32_t i : indices) {
    Instance& instance = snapshot->instances[i];
    instance.walk.set = set.get();
    instance.member = static_cast<uint32_t>(set->members.size());
    add_member(*drawn[i], i, origin, set.get());
    placements.push_back({drawn[i]->prototype->object, set->members.back().to_set});
    open |= instance.shells->any_open;
  }
  if (open) set->bounds = widened(set->bounds);
  set->scene = build_instanced_scene(device, placements);
  if (!set->scene) return false;
  snapshot->memory_bytes += set->scene->memory_bytes() + set->members.size() * sizeof(WalkSet::Member);
  snapshot->walk_sets.push_back(std::move(set));
  return true;
}

}  // namespace

bool prepare_scattering(const std::vector<const InstanceDescription*>& drawn,
                        const std::shared_ptr<TraceDevice>& device, SceneSnapshot* snapshot) {
  std::map<std::string, std::vector<uint32_t>> sets;
  for (uint32_t i = 0; i < drawn.size(); ++i) {
    Instance& instance = snapshot->instances[i];
    if (!scatters(instance)) continue;
    instance.shells = &instance.prototype->shells();
    walk_alone(&instance);
    if (!drawn[i]->subsurface_set.empty())
      sets[drawn[i]->subsurface_set].push_back(i);
    else if (!is_simple(*instance.shells) && !walk_together(drawn, {i}, device, snapshot))
      return false;
  }
  for (const auto& [name, indices] : sets) {
    if (indices.size() == 1 && is_simple(*snapshot->instances[indices.front()].shells)) continue;
    if (!walk_together(drawn, indices, device, snapshot)) return false;
  }
  return true;
}

}  // namespace alabaster
