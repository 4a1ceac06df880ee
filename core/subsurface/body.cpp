#include "core/subsurface/body.h"

#include <algorithm>
#include <limits>

#include "core/diagnostics/check.h"

namespace alabaster {
namespace {

// Measured (testenv/statistical/results/walk_efficiency.md): in a body less than so many mean free paths across from
// the middle, walks leave before spheres find room, and before guiding has saved what it costs.
constexpr float kRoom = 30;

// A step in a union asks the grids of all members. In rows of overlapping spheres, sphere steps save 15 % of the CPU
// time up to 16 members and 9 % at 32, but cost 20 % at 128 (testenv/statistical/results/walk_efficiency.md).
constexpr size_t kMostGrids = 16;

// World distance from the middle of a member's bounds to their nearest side, at least.
float half_thickness(const SubsurfaceBody::Member& member) {
  const Vec3f extent = member.mesh->bounds.extent();
  return 0.5f * std::min(extent.x, std::min(extent.y, extent.z)) * member.least_stretch;
}

bool has_room_for_spheres(const SubsurfaceBody::Member& member, float mfp) {
  // A grid of 128 voxels bounds no distance below two; deeper than kDeep few walks go.
  constexpr float kVoxelsAcross = 128, kDeep = 32;
  const float voxel = max_component(member.mesh->bounds.extent()) * member.least_stretch / kVoxelsAcross;
  return half_thickness(member) > kRoom * mfp && 2 * voxel < kDeep * mfp;
}

}  // namespace

const SubsurfaceBody::Maps& SubsurfaceBody::Member::move_to(float time, std::optional<Maps>* moved) const {
  const Affine map = posed(poses, time);
  return moved->emplace(Maps{map, inverse(map)});
}

const SubsurfaceBody::Maps& SubsurfaceBody::Member::place(uint32_t index, std::optional<Maps>* moved) const {
  const Placement& placement = array->placement(index - instance);
  return moved->emplace(Maps{placement.object_to_world, placement.world_to_object});
}

bool SubsurfaceBody::bounds_distances() const {
  return members.front().distances != nullptr;
}

double SubsurfaceBody::distance_to_contents(const Vec3f& p) const {
  double nearest = std::numeric_limits<double>::infinity();
  if (to_contents)
    nearest = grid_bounds.contains(p) ? static_cast<double>(to_contents->bound(p)) : distance_to_bounds(grid_bounds, p);
  for (const Bounds& box : boxes_within) nearest = std::min(nearest, distance_to_bounds(box, p));
  return nearest;
}

Vec3f SubsurfaceBody::below(const SubsurfaceEntry& entry) const {
  const SurfaceHit& outer = entry.hit;
  if (!is_union()) return offset_point(outer.p_object, -outer.ng_object, outer.offset_object);
  const Member& m = members[entry.member];
  std::optional<Maps> moved;
  const Maps& maps = m.at(entry.triangle.time, &moved);
  const SurfacePoint hit = surface_point(*m.mesh, entry.triangle, maps.to_body, maps.to_object);
  return offset_point(hit.p, -outer.ng, hit.offset);
}

Vec3f SubsurfaceBody::to_walk_space(const SubsurfaceEntry& entry, const Vec3f& p) const {
  std::optional<Maps> moved;
  return is_union() ? p - origin : members[entry.member].at(entry.triangle, &moved).to_object.point(p);
}

bool SubsurfaceBody::leaves(uint32_t member, const TriangleHit& hit, const Vec3f& direction) const {
  const Member& m = members[member];
  std::optional<Maps> moved;
  return alabaster::leaves(*m.mesh, *m.shells, hit, m.at(hit, &moved).to_object.vector(direction));
}

bool SubsurfaceBody::is_inner_wall(uint32_t member, TriangleHit hit, const Vec3f& direction) const {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  hit.instance = member;
  const Vec3f outward = leaves(member, hit, direction) ? direction : -direction;
  return contains_in_body_space({cross(hit, outward).beyond, outward, kInfinity, hit.time}, &members[member]);
}

bool SubsurfaceBody::contains(Ray ray) const {
  ray.org -= origin;
  ray.tmax = std::numeric_limits<float>::infinity();
  return contains_in_body_space(ray, nullptr);
}

Crossed SubsurfaceBody::cross(const TriangleHit& hit, const Vec3f& direction) const {
  const Member& m = members[hit.instance];
  std::optional<Maps> moved;
  const Maps& maps = m.at(hit.time, &moved);
  const SurfacePoint s = surface_point(*m.mesh, hit, maps.to_body, maps.to_object);
  const float side = dot(s.ng, direction) >= 0 ? 1.0f : -1.0f;
  return {m.shells->flags(hit.triangle), alabaster::leaves(*m.mesh, *m.shells, hit, maps.to_object.vector(direction)),
          offset_point(s.p, s.ng * side, s.offset)};
}

bool SubsurfaceBody::contains_in_body_space(const Ray& ray, const Member* left) const {
  const auto holds = [&](const Member& m) {
    if (!m.bounds.contains(ray.org) || !m.shells->any_closed || (&m == left && !m.shells->overlapping)) return false;
    std::optional<Maps> moved;
    const Affine& to_object = m.at(ray.time, &moved).to_object;
    Ray in_object = ray;
    in_object.org = to_object.point(ray.org);
    in_object.dir = to_object.vector(ray.dir);
    return winding_number(*m.mesh, *m.shells, *m.object, in_object) > 0;
  };
  if (places) return places->any_at(ray.org, [&](uint32_t member) { return holds(members[member]); });
  return std::any_of(members.begin(), members.end(), holds);
}

float depth_below_surface(const SurfaceHit& hit, const Affine& object_to_world) {
  return std::abs(dot(object_to_world.vector(hit.ng_object * hit.offset_object), hit.ng));
}

void MeanFreePaths::extend(const WalkMedium& medium) {
  const float mfp = medium.longest_mean_free_path();
  longest = std::max(longest, mfp);
  if (medium.worthwhile.sphere_steps) of_long_walks = std::max(of_long_walks, mfp);
}

void plan_shortcuts(const std::vector<MeanFreePaths>& paths, const std::vector<const MeshInterior*>& interiors,
                    SubsurfaceBody* body, const CancelToken& cancel) {
  CHECK_EQ(paths.size(), body->members.size());
  CHECK_EQ(interiors.size(), body->members.size());
  bool anywhere = false;
  for (size_t i = 0; i < body->members.size(); ++i) {
    SubsurfaceBody::Member& m = body->members[i];
    if (!m.array) m.least_stretch = m.poses.empty() ? least_stretch(m.to_body) : least_stretch_over(m.poses);
    // Behind an open mesh the medium has no end.
    m.room_to_guide = m.shells->any_open || half_thickness(m) > kRoom * paths[i].longest;
    m.room_for_spheres = paths[i].of_long_walks > 0 && has_room_for_spheres(m, paths[i].of_long_walks);
    anywhere |= m.room_for_spheres;
  }
  if (!anywhere || body->members.size() > kMostGrids) return;
  // A sphere must keep clear of every member, so all of them need a grid.
  for (size_t i = 0; i < body->members.size(); ++i) {
    const Mesh& mesh = *body->members[i].mesh;
    // A grid knows one shape.
    body->members[i].distances = mesh.deforms() ? nullptr : interiors[i]->distances(mesh, cancel);
    if (body->members[i].distances) continue;
    for (SubsurfaceBody::Member& m : body->members) m.distances = nullptr;
    return;
  }
}

Bounds widened(const Bounds& bounds) {
  if (bounds.empty()) return bounds;
  const Vec3f by(length(bounds.extent()));
  return {bounds.lower - by, bounds.upper + by};
}

}  // namespace alabaster
