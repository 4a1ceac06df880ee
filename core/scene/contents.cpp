#include "core/scene/contents.h"

#include <algorithm>
#include <numeric>

#include "core/scene/clear_bodies.h"
#include "core/scene/world_placement.h"

namespace alabaster {
namespace {

bool is_cloudy(const DisneyMaterial& material) {
  return material.scatters() && material.constants.spec_trans > 0;
}

// A proof looks at no more faces, of both together, and at no more points; all proofs of a commit at no more faces.
constexpr size_t kMostFaces = size_t(1) << 20, kMostPointsOfProof = size_t(1) << 16;
constexpr size_t kMostFacesOfAll = size_t(1) << 24;

// The boxes of the faces that may meet `region`, widened by rounding.
std::vector<Bounds> boxes_of_faces(const Instance& instance, const Bounds& region) {
  std::vector<Bounds> boxes;
  const Mesh& mesh = instance.prototype->mesh;
  for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    Bounds box;
    for (const Vec3f& corner : mesh.corners_at(t, 0)) box.extend(instance.object_to_world.point(corner));
    if (overlap(wider(box), region)) boxes.push_back(wider(box));
  }
  return boxes;
}

// True if a closed shell of `body` contains a point of the other mesh.
bool holds_points_of(const Instance& body, const Instance& other, const CancelToken& cancel) {
  const MeshPrototype& prototype = *body.prototype;
  const MeshShells& shells = prototype.shells(cancel);
  for (const Vec3f& p : other.prototype->mesh.points) {
    const Vec3f q = body.world_to_object.point(other.object_to_world.point(p));
    if (!prototype.mesh.bounds.contains(q)) continue;
    cancel.check();
    if (winding_number(prototype.mesh, shells, *prototype.object, {q, normalize(Vec3f(0.36f, 0.48f, 0.8f))}) > 0)
      return true;
  }
  return false;
}

// Empty: it has none, or is a mesh.
BoundsDouble finite_box(const Light& light) {
  const LightExtent extent = std::visit([](const auto& l) { return l.extent(); }, light);
  return extent.finite && !std::holds_alternative<MeshLight>(light) ? extent.box : BoundsDouble();
}

BoundsDouble world_box(const InstanceDescription& d) {
  BoundsDouble box = world_bounds(d.prototype->mesh.bounds, d.object_to_world);
  for (const Matrix4d& pose : d.poses) box.extend(world_bounds(d.prototype->mesh.bounds, pose));
  return box;
}

// Empty: it has no place.
BoundsDouble world_box(LightParameters d) {
  if (!is_valid_affine(d.light_to_world) || !is_within_reach(d.light_to_world)) return {};
  d.texture = nullptr;  // which its place does not need
  d.ies = nullptr;
  return finite_box(make_light(d, Vec3d(0, 0, 0)));
}

Bounds rounded(const BoundsDouble& box) {
  return wider({Vec3f(box.lower), Vec3f(box.upper)});
}

}  // namespace

bool is_cloudy(const InstanceDescription& instance) {
  return !used_slots(instance, [](const DisneyMaterial& m) { return is_cloudy(m); }).empty();
}

bool has_opaque_faces(const InstanceDescription& instance) {
  const auto may_be_opaque = [](const DisneyMaterial& m) {
    const float metallic = m.constants.metallic;
    return !m.scatters() || m.is_partly_closed() || metallic == 1 ||
           (metallic > 0 && m.varies(&DisneyParameters::metallic));
  };
  return !used_slots(instance, may_be_opaque).empty();
}

bool is_opaque_everywhere(const InstanceDescription& instance) {
  return used_slots(instance, [](const DisneyMaterial& m) { return m.is_translucent(); }).empty();
}

void ContentFinder::build() {
  std::vector<Bounds> boxes;
  const auto add = [&](const Bounds& box, uint32_t number) {
    if (box.empty()) return;
    boxes.push_back(wider(box));
    of_box_.push_back(number);
  };
  const auto alone = static_cast<uint32_t>(snapshot_.instances.size());
  for (uint32_t i = 0; i < alone; ++i) add(bounds_in_render_space(snapshot_.instances[i]), i);
  for (uint32_t i = 0; i < snapshot_.arrays.size(); ++i) add(snapshot_.arrays[i].placed->bounds(), alone + i);
  boxes_.emplace(std::move(boxes));
}

bool ContentFinder::are_apart(const Instance& body, const Instance& other) {
  if (!body.is_still() || !other.is_still()) return false;
  const Mesh &of_body = body.prototype->mesh, &of_other = other.prototype->mesh;
  const size_t count = of_body.triangles.size() + of_other.triangles.size();
  if (count > kMostFaces || of_other.points.size() > kMostPointsOfProof || faces_seen_ + count > kMostFacesOfAll)
    return false;
  faces_seen_ += count;
  const Bounds a = wider(bounds_in_render_space(body)), b = wider(bounds_in_render_space(other));
  const BoxTree faces(boxes_of_faces(body, b));
  for (const Bounds& face : boxes_of_faces(other, a)) {
    cancel_.check();
    bool meets = false;
    faces.search([&](const Bounds& box) { return !meets && overlap(box, face); }, [&](uint32_t) { meets = true; });
    if (meets) return false;
  }
  return !holds_points_of(body, other, cancel_);
}

ContentFinder::Contents ContentFinder::find(const std::vector<uint32_t>& members) {
  if (!boxes_) build();
  Contents contents;
  const auto alone = static_cast<uint32_t>(snapshot_.instances.size());
  for (const uint32_t member : members) {
    const Instance& body = snapshot_.instances[member];
    const Bounds box = wider(bounds_in_render_space(body));
    boxes_->search([&](const Bounds& b) { return overlap(b, box); },
                   [&](uint32_t i) {
                     const uint32_t number = of_box_[i];
                     if (std::binary_search(members.begin(), members.end(), number)) return;
                     if (number >= alone)
                       contents.arrays.push_back(&snapshot_.arrays[number - alone]);
                     else if (!are_apart(body, snapshot_.instances[number]))
                       contents.alone.push_back(number);
                   });
    for (const Light& light : snapshot_.lights.lights())
      if (const BoundsDouble of_light = finite_box(light); !of_light.empty() && overlap(rounded(of_light), box))
        contents.lights.push_back(rounded(of_light));
  }
  const auto sort_unique = [](auto* all) {
    std::sort(all->begin(), all->end());
    all->erase(std::unique(all->begin(), all->end()), all->end());
  };
  sort_unique(&contents.alone);
  sort_unique(&contents.arrays);
  return contents;
}

bool ArrayNeighbours::any_in(const InstanceArrayDescription& array, const CancelToken& cancel) {
  const auto has_shape = [](const InstanceDescription& d) {
    return d.prototype && !d.prototype->mesh.triangles.empty() && is_valid_affine(d.object_to_world);
  };
  if (!boxes_) {
    std::vector<Bounds> boxes;
    for (const InstanceDescription& d : description_.instances)
      if (has_shape(d)) boxes.push_back(rounded(world_box(d)));
    for (const LightParameters& d : description_.lights)
      if (const BoundsDouble box = world_box(d); !box.empty()) boxes.push_back(rounded(box));
    arrays_.resize(boxes.size(), nullptr);
    for (const InstanceArrayDescription& other : description_.arrays) {
      BoundsDouble all;
      for (size_t i = 0; i < other.places->size(); ++i)
        if (const auto place = other.places->at(i)) all.extend(world_bounds(other.look.prototype->mesh.bounds, *place));
      if (!all.empty()) boxes.push_back(rounded(all)), arrays_.push_back(&other);
    }
    boxes_.emplace(std::move(boxes));
  }
  bool found = false;
  for (size_t i = 0; i < array.places->size() && !found; ++i) {
    if (i % 1024 == 0) cancel.check();
    const auto place = array.places->at(i);
    if (!place) continue;
    const Bounds box = rounded(world_bounds(array.look.prototype->mesh.bounds, *place));
    boxes_->search([&](const Bounds& b) { return !found && overlap(b, box); },
                   [&](uint32_t k) { found |= arrays_[k] != &array; });
  }
  return found;
}

bool bound_contents(const ContentFinder::Contents& contents, const SceneSnapshot& snapshot, const CancelToken& cancel,
                    SubsurfaceBody* body) {
  constexpr uint32_t kResolution = 128;
  constexpr size_t kMostBoxes = 16;
  Mesh all;
  const auto add = [&](const Mesh& mesh, const Affine& to_render) {
    const auto first = static_cast<uint32_t>(all.points.size());
    for (const Vec3f& p : mesh.points) {
      all.points.push_back(to_render.point(p) - body->origin);
      all.bounds.extend(all.points.back());
    }
    for (const Corners& c : mesh.triangles) all.triangles.push_back({first + c[0], first + c[1], first + c[2]});
    return all.triangles.size() <= kMostFaces;
  };
  for (const Bounds& light : contents.lights)
    body->boxes_within.push_back({light.lower - body->origin, light.upper - body->origin});
  for (const uint32_t i : contents.alone) {
    const Instance& instance = snapshot.instances[i];
    cancel.check();
    if (!instance.is_still()) {
      const Bounds box = wider(bounds_in_render_space(instance));
      body->boxes_within.push_back({box.lower - body->origin, box.upper - body->origin});
    } else if (!add(instance.prototype->mesh, instance.object_to_world)) {
      return false;
    }
  }
  for (const InstanceArray* array : contents.arrays)
    for (size_t i = 0; i < array->placed->size(); ++i)
      if (!add(array->look.prototype->mesh, array->placed->traced.placement(static_cast<uint32_t>(i)).object_to_world))
        return false;
  if (body->boxes_within.size() > kMostBoxes) return false;
  if (all.triangles.empty()) return true;
  body->grid_bounds = all.bounds;
  body->to_contents = build_distance_grid(all, kResolution, cancel);
  return body->to_contents != nullptr;
}

}  // namespace alabaster
