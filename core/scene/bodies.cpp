#include "core/scene/bodies.h"

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

#include "core/scene/clear_bodies.h"
#include "core/scene/contents.h"
#include "core/scene/world_placement.h"
#include "core/subsurface/body.h"

namespace alabaster {
namespace {

using Member = SubsurfaceBody::Member;

// The walk's every crossing is the end of the medium.
bool is_simple(const MeshShells& shells) {
  return !shells.any_open && !shells.overlapping;
}

// Where a member stands in its body.
struct MemberMotion {
  Affine to_body, to_object;
  std::vector<Affine> poses;  // of one that moves

  Bounds transformed(const Bounds& b) const {
    Bounds out;
    for (const Vec3f& corner : b.corners()) {
      out.extend(to_body.point(corner));
      for (const Affine& pose : poses) out.extend(pose.point(corner));
    }
    return out;
  }
};

// The BVHs of a snapshot's unions, which do not depend on where a union stands in the scene.
class KnownUnions {
 public:
  explicit KnownUnions(const SceneSnapshot* snapshot) {
    if (!snapshot) return;
    for (const auto& body : snapshot->bodies)
      if (body->is_union() && body->contents.empty()) unions_.emplace(key(*body), body.get());
  }
  const SubsurfaceBody* find(const SubsurfaceBody& body) const {
    const auto same = [](const Member& a, const Member& b) {
      return a.object == b.object && a.to_body == b.to_body && a.poses == b.poses;
    };
    const auto [first, last] = unions_.equal_range(key(body));
    for (auto it = first; it != last; ++it)
      if (std::equal(body.members.begin(), body.members.end(), it->second->members.begin(), it->second->members.end(),
                     same))
        return it->second;
    return nullptr;
  }

 private:
  using Key = std::tuple<const ObjectScene*, size_t, float>;
  static Key key(const SubsurfaceBody& body) {
    const Member& first = body.members.front();
    return {first.object, body.members.size(), first.to_body.x.x};
  }
  std::multimap<Key, const SubsurfaceBody*> unions_;
};

class BodyPlanner {
 public:
  BodyPlanner(const BodySources& sources, SceneSnapshot* snapshot)
      : drawn_(sources.drawn.alone),
        looks_(sources.drawn.looks),
        device_(sources.device),
        known_(sources.last),
        snapshot_(*snapshot),
        clear_(*snapshot),
        finder_(*snapshot, sources.cancel),
        cancel_(sources.cancel) {}

  bool plan() {
    snapshot_.clear_meetings = clear_.meetings();
    rank_clear_bodies(&snapshot_);
    std::map<std::string, std::vector<uint32_t>> sets;
    for (uint32_t i = 0; i < drawn_.size(); ++i) {
      const std::string& set = drawn_[i]->subsurface_set;
      if (scattering_slots(*drawn_[i]).empty()) {
        if (!set.empty() && is_opaque_everywhere(*drawn_[i])) opaque_of_sets_[set].push_back(i);
        continue;
      }
      snapshot_.features.subsurface = true;
      if (!set.empty())
        sets[set].push_back(i);
      else if (!try_body({i}))
        return false;
    }
    for (uint32_t i = 0; i < looks_.size(); ++i)
      in_name_of(looks_[i]->name, [&] { add_array(*looks_[i], &snapshot_.arrays[i]); });
    return std::all_of(sets.begin(), sets.end(), [&](const auto& set) { return try_body(set.second); });
  }

 private:
  // In the name of its first member.
  bool try_body(const std::vector<uint32_t>& indices) {
    bool added = false;
    in_name_of(drawn_[indices.front()]->name, [&] { added = add_body(indices); });
    return added;
  }

  bool add_body(const std::vector<uint32_t>& indices) {
    cancel_.check();
    auto body = std::make_shared<SubsurfaceBody>();
    const MeshShells& first = drawn_[indices.front()]->prototype->shells(cancel_);
    const ContentFinder::Contents contents = find_contents(indices, body.get());
    if (indices.size() == 1 && is_simple(first) && body->contents.empty() && !body->lights_within)
      add_alone(indices.front(), body.get());
    else if (!unite(indices, contents, body.get()))
      return false;
    std::vector<const InstanceDescription*> members;
    members.reserve(indices.size());
    for (const uint32_t i : indices) members.push_back(drawn_[i]);
    plan_walks(members, body.get());
    if (body->occupied && body->bounds_distances()) {
      if (!bound_contents(contents, snapshot_, cancel_, body.get()))
        for (Member& member : body->members) member.distances = nullptr;
      if (body->to_contents) snapshot_.memory_bytes += body->to_contents->memory_bytes();
    }
    Bounds box;
    for (const uint32_t i : indices) box.extend(bounds_in_render_space(snapshot_.instances[i]));
    body->touched = clear_.that_meet(box, indices);
    snapshot_.bodies.push_back(std::move(body));
    return true;
  }

  // What stands in the body, behind its clear walls. Behind diffuse ones, as artists expect of other renderers, walks
  // know the body alone, its opaque faces, and opaque members of its set.
  ContentFinder::Contents find_contents(const std::vector<uint32_t>& indices, SubsurfaceBody* body) {
    ContentFinder::Contents contents;
    const auto any = [&](const auto& is_such) {
      return std::any_of(indices.begin(), indices.end(), [&](uint32_t i) { return is_such(*drawn_[i]); });
    };
    const auto is_closed_and_cloudy = [&](const InstanceDescription& d) {
      return is_cloudy(d) && d.prototype->shells(cancel_).any_closed;
    };
    if (any(is_closed_and_cloudy)) {
      contents = finder_.find(indices);
    } else if (const auto opaque = opaque_of_sets_.find(drawn_[indices.front()]->subsurface_set);
               opaque != opaque_of_sets_.end()) {
      contents.alone = opaque->second;
    }
    body->contents = contents.alone;
    for (const InstanceArray* array : contents.arrays)
      for (uint32_t i = 0; i < array->placed->size(); ++i) body->contents.push_back(array->first + i);
    body->lights_within = !contents.lights.empty();
    body->opaque_faces = any(has_opaque_faces);
    body->occupied = body->opaque_faces || body->lights_within || !body->contents.empty();
    return contents;
  }

  void add_alone(uint32_t index, SubsurfaceBody* body) {
    const Instance& instance = snapshot_.instances[index];
    add_member(index, {instance.object_to_world, instance.world_to_object, instance.poses}, body);
    body->bounds = instance.prototype->mesh.bounds;
  }

  // All instances are the same body, each where it stands.
  void add_array(const InstanceDescription& look, InstanceArray* array) {
    if (scattering_slots(look).empty()) return;
    snapshot_.features.subsurface = true;
    auto body = std::make_shared<SubsurfaceBody>();
    const MeshPrototype& prototype = *look.prototype;
    array->look.body = body.get();
    Member& member = body->members.emplace_back();
    member.instance = array->first;
    member.array = &array->placed->traced;
    member.mesh = &prototype.mesh;
    member.shells = &prototype.shells(cancel_);
    member.object = prototype.object.get();
    member.bounds = body->bounds = prototype.mesh.bounds;
    member.least_stretch = array->placed->plan.least_stretch();
    body->opaque_faces = body->occupied = has_opaque_faces(look);
    plan_walks({&look}, body.get());
    body->touched = clear_.that_meet(array->placed->bounds(), {});
    snapshot_.bodies.push_back(std::move(body));
  }

  bool unite(const std::vector<uint32_t>& indices, const ContentFinder::Contents& contents, SubsurfaceBody* body) {
    // The cells of arrays are traced in render space.
    const Vec3d origin = contents.arrays.empty() ? world_centre(indices) : snapshot_.origin;
    body->origin = Vec3f(origin - snapshot_.origin);
    std::vector<InstancePlacement> placements;
    bool open = false;
    for (const uint32_t i : indices) {
      const Matrix4d m = moved_to(drawn_[i]->object_to_world, origin);
      MemberMotion motion{to_affine(m), to_affine(m.inverse()), {}};
      for (const Matrix4d& pose : drawn_[i]->poses) motion.poses.push_back(to_affine(moved_to(pose, origin)));
      const Member& member = add_member(i, motion, body);
      body->bounds.extend(member.bounds);
      placements.push_back({drawn_[i]->prototype->object, member.to_body, member.poses});
      open |= member.shells->any_open;
    }
    if (open) body->bounds = widened(body->bounds);
    for (const uint32_t i : contents.alone) {
      placements.push_back({drawn_[i]->prototype->object, to_affine(moved_to(drawn_[i]->object_to_world, origin)), {}});
      for (const Matrix4d& pose : drawn_[i]->poses)
        placements.back().poses.push_back(to_affine(moved_to(pose, origin)));
    }
    std::vector<InstanceCells> arrays;
    for (const InstanceArray* array : contents.arrays) arrays.push_back(array->placed->traced);
    const SubsurfaceBody* const known = body->contents.empty() ? known_.find(*body) : nullptr;
    if (known)
      body->scene = known->scene, body->places = known->places;
    else if (!build_trees(placements, arrays, body))
      return false;
    snapshot_.memory_bytes += body->scene->memory_bytes();
    return true;
  }

  bool build_trees(const std::vector<InstancePlacement>& placements, const std::vector<InstanceCells>& arrays,
                   SubsurfaceBody* body) const {
    // Fewer boxes are compared with a point as fast one by one.
    constexpr size_t kFew = 32;
    const auto cancelled = [this] { return cancel_.is_cancelled(); };
    body->scene = build_instanced_scene(device_, placements, cancelled, arrays);
    std::vector<Bounds> boxes;
    for (const Member& member : body->members) boxes.push_back(member.bounds);
    if (body->scene && boxes.size() > kFew) body->places = build_bounds_tree(device_, std::move(boxes), cancelled);
    const bool built = body->scene && (body->places || body->members.size() <= kFew);
    if (!built) cancel_.check();
    return built;
  }

  const Member& add_member(uint32_t index, const MemberMotion& motion, SubsurfaceBody* body) {
    Instance& instance = snapshot_.instances[index];
    instance.body = body;
    instance.member = static_cast<uint32_t>(body->members.size());
    const MeshPrototype& prototype = *instance.prototype;
    body->members.push_back({{motion.to_body, motion.to_object},
                             index,
                             &prototype.mesh,
                             &prototype.shells(cancel_),
                             prototype.object.get(),
                             motion.poses,
                             motion.transformed(prototype.mesh.bounds)});
    snapshot_.memory_bytes += sizeof(Member) + motion.poses.size() * sizeof(Affine);
    return body->members.back();
  }

  Vec3d world_centre(const std::vector<uint32_t>& indices) const {
    BoundsDouble centres;
    for (const uint32_t i : indices)
      centres.extend(transform_point(Vec3d(drawn_[i]->prototype->mesh.bounds.center()), drawn_[i]->object_to_world));
    return centres.center();
  }

  // The media of each member's materials, and the shortcuts that pay in them.
  void plan_walks(const std::vector<const InstanceDescription*>& members, SubsurfaceBody* body) {
    std::vector<MeanFreePaths> paths(members.size());
    std::vector<const MeshInterior*> interiors;
    float least = 1, most = 0;
    for (size_t i = 0; i < members.size(); ++i) {
      interiors.push_back(&members[i]->prototype->interior);
      const auto& materials = members[i]->materials;
      body->members[i].media.resize(materials.size());
      for (const size_t slot : scattering_slots(*members[i])) {
        extend(*materials[slot], &paths[i]);
        body->has_holes |= materials[slot]->is_partly_opaque();
        body->members[i].media[slot] = media_of(*materials[slot]);
        const float weight = materials[slot]->constants.subsurface_weight;
        least = std::min(least, weight), most = std::max(most, weight);
        body->weighted |= materials[slot]->is_partly_closed();
      }
    }
    body->weighted |= least < most;
    plan_shortcuts(paths, interiors, body, cancel_);
  }

  // A texture may be white anywhere.
  static void extend(const DisneyMaterial& material, MeanFreePaths* paths) {
    DisneyParameters p = material.constants;
    if (material.varies_albedo()) p.subsurface_color = Rgb(1.0f);
    p.take_mean_free_path();
    paths->extend(make_medium(p.medium_albedo(), p.scatter_distance, AlbedoInversion::exact, p.scatter_anisotropy));
  }

  std::shared_ptr<const MaterialMedia> media_of(const DisneyMaterial& material) {
    if (material.varies_albedo() || material.varies(&DisneyParameters::scatter_distance) ||
        material.varies(&DisneyParameters::mean_free_path) || material.varies(&DisneyParameters::scatter_anisotropy))
      return nullptr;
    auto& media = media_[&material];
    DisneyParameters p = material.constants;
    p.take_mean_free_path();
    if (!media) media = std::make_shared<MaterialMedia>(p.medium_albedo(), p.scatter_distance, p.scatter_anisotropy);
    return media;
  }

  const std::vector<const InstanceDescription*>&drawn_, &looks_;
  const std::shared_ptr<TraceDevice>& device_;
  const KnownUnions known_;
  SceneSnapshot& snapshot_;
  const ClearBoxes clear_;
  ContentFinder finder_;
  std::map<std::string, std::vector<uint32_t>> opaque_of_sets_;
  const CancelToken cancel_;
  std::map<const DisneyMaterial*, std::shared_ptr<const MaterialMedia>> media_;
};

}  // namespace

bool scatter_separately(const InstanceDescription& look, const CancelToken& cancel) {
  return scattering_slots(look).empty() || (look.subsurface_set.empty() && is_simple(look.prototype->shells(cancel)));
}

bool plan_bodies(const BodySources& sources, SceneSnapshot* snapshot) {
  return BodyPlanner(sources, snapshot).plan();
}

}  // namespace alabaster
