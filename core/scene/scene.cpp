#include "core/scene/scene.h"

#include <algorithm>
#include <set>
#include <utility>

#include "core/sampling/warp.h"
#include "core/scene/bodies.h"
#include "core/scene/lit_surfaces.h"

namespace alabaster {
namespace {

BoundsDouble world_bounds(const InstanceDescription& d) {
  BoundsDouble world;
  const Bounds& object = d.prototype->mesh.bounds;
  if (object.empty()) return world;
  for (const Vec3f& corner : object.corners()) {
    world.extend(transform_point(Vec3d(corner), d.object_to_world));
    for (const Matrix4d& pose : d.poses) world.extend(transform_point(Vec3d(corner), pose));
  }
  return world;
}

// False for a transform that is not finite or reaches beyond what can be traced. A singular one within reach hides an
// instance or a light by a scale of zero, as animations do.
bool is_within_reach(const Matrix4d& m) {
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      if (!(std::abs(m[i][j]) < double(kTraceLimit))) return false;
  return true;
}

// The rest of the scene is drawn without an instance that cannot be placed or traced. It is an error unless the
// instance has no extent.
void leave_out(const InstanceDescription& d, const char* reason, const DiagnosticSink& sink,
               std::vector<std::string>* left_out) {
  const bool near = is_within_reach(d.object_to_world) && std::all_of(d.poses.begin(), d.poses.end(), is_within_reach);
  report(sink, near ? Severity::warning : Severity::error, "instance.transform", d.name,
         std::string(reason) + ": the instance is left out; check its " + (near ? "scale" : "transform"));
  if (!near) left_out->push_back(d.name);
}

bool is_drawable(const InstanceDescription& d, const DiagnosticSink& sink, std::vector<std::string>* left_out) {
  if (!d.prototype || !d.prototype->object || d.prototype->mesh.triangles.empty() || d.materials.empty()) return false;
  if (!is_valid_affine(d.object_to_world) || !std::all_of(d.poses.begin(), d.poses.end(), is_valid_affine)) {
    leave_out(d, "the transform is not finite, not affine or not invertible in single precision", sink, left_out);
    return false;
  }
  const BoundsDouble bounds = world_bounds(d);
  const double limit = kTraceLimit;
  if (bounds.lower.x > -limit && bounds.lower.y > -limit && bounds.lower.z > -limit && bounds.upper.x < limit &&
      bounds.upper.y < limit && bounds.upper.z < limit)
    return true;
  leave_out(d, "the transform takes it beyond 1e17", sink, left_out);
  return false;
}

Matrix4d moved_to_render_space(Matrix4d m, const Vec3d& origin) {
  for (int i = 0; i < 3; ++i) m[3][i] -= origin[i];
  return m;
}

Instance place(const InstanceDescription& d, const Vec3d& origin) {
  const Matrix4d m = moved_to_render_space(d.object_to_world, origin);
  Instance instance;
  instance.prototype = d.prototype.get();
  instance.object_to_world = to_affine(m);
  instance.world_to_object = to_affine(m.inverse());
  for (const Matrix4d& pose : d.poses) instance.poses.push_back(to_affine(moved_to_render_space(pose, origin)));
  instance.prim_id = d.prim_id;
  instance.instance_id = d.instance_id;
  for (const auto& material : d.materials) {
    instance.materials.push_back(material.get());
    instance.see_through |= material->is_partly_opaque();
    for (const auto* map : {&material->normal_map, &material->coat_normal_map})
      if (*map && !(*map)->is_bump && !instance.tangents)
        instance.tangents = d.prototype->tangents.of(d.prototype->mesh, (*map)->uv_set);
  }
  instance.single_sided = !d.double_sided && !d.prototype->mesh.outward;
  instance.see_through |= instance.single_sided;
  return instance;
}

// Emission at a point of a triangle, of which only a share may be there.
Rgb emission_at(const Instance& instance, uint32_t triangle, const Vec2f& b) {
  const Mesh& mesh = instance.prototype->mesh;
  TriangleHit hit;
  hit.triangle = triangle, hit.u = b.x, hit.v = b.y;
  const Vec2f uv = mesh.uv_sets.empty() ? Vec2f(0, 0) : interpolated<Vec2f>(mesh.uv_sets.front(), mesh, hit);
  const HitPrimvars at(mesh, hit, uv);
  const DisneyMaterial& material = instance.material(triangle);
  return material.evaluate(at).emission * material.coverage(at);
}

bool has_varying_emission(const DisneyMaterial& material) {
  return material.varies(&DisneyParameters::emission) || material.is_partly_opaque();
}

// The mean over a triangle by points spread over it. Where it misses all bright texels the triangle is never chosen,
// and paths that meet it count in full.
Rgb mean_emission(const Instance& instance, uint32_t triangle) {
  const DisneyMaterial& material = instance.material(triangle);
  if (!has_varying_emission(material)) return material.constants.emission;
  const int side = instance.prototype->mesh.triangles.size() > 65536 ? 2 : 8;
  const float step = 1 / static_cast<float>(side);
  Rgb sum(0.0f);
  for (int i = 0; i < side * side; ++i) {
    const Vec2f u((static_cast<float>(i % side) + 0.5f) * step, (static_cast<float>(i / side) + 0.5f) * step);
    const Vec2f b = sample_uniform_triangle(u);
    sum += emission_at(instance, triangle, {b.y, 1 - b.x - b.y});
  }
  return sum * (step * step);
}

Bounds bounds_in_render_space(const Instance& instance) {
  Bounds bounds;
  for (const Vec3f& corner : instance.prototype->mesh.bounds.corners()) {
    bounds.extend(instance.object_to_world.point(corner));
    for (const Affine& pose : instance.poses) bounds.extend(pose.point(corner));
  }
  return bounds;
}

bool has_clear_interior(const InstanceDescription& d) {
  return std::any_of(d.materials.begin(), d.materials.end(),
                     [](const auto& m) { return m->transmits() && !m->constants.thin; });
}

// True if some triangle has a material that emits.
bool emits(const Instance& instance) {
  if (std::none_of(instance.materials.begin(), instance.materials.end(), [](const auto* m) { return m->emits(); }))
    return false;
  for (uint32_t i = 0; i < instance.prototype->mesh.triangles.size(); ++i)
    if (instance.material(i).emits()) return true;
  return false;
}

// The emissive triangles of an instance that emits and stands still, in render space.
MeshLight make_mesh_light(const Instance& instance, uint32_t index) {
  const Mesh& mesh = instance.prototype->mesh;
  std::vector<MeshLight::Triangle> triangles;
  std::vector<uint32_t> ids;
  bool varies = false;
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    const DisneyMaterial& material = instance.material(static_cast<uint32_t>(i));
    if (!material.emits()) continue;
    const auto corner = [&](size_t c) { return instance.object_to_world.point(mesh.points[mesh.triangles[i][c]]); };
    triangles.push_back({corner(0), corner(1), corner(2), mean_emission(instance, static_cast<uint32_t>(i)),
                         instance.single_sided && !material.is_translucent()});
    ids.push_back(static_cast<uint32_t>(i));
    varies |= has_varying_emission(material);
  }
  if (!varies) return MeshLight(index, std::move(triangles), ids);
  // The snapshot keeps its instances where they are.
  return MeshLight(index, std::move(triangles), ids,
                   [&instance](uint32_t triangle, const Vec2f& b) { return emission_at(instance, triangle, b); });
}

bool has_no_size(const LightDescription& d) {
  if (d.type == LightType::rect) return d.width == 0 || d.height == 0;
  return (d.type == LightType::disk && d.radius == 0) ||
         (d.type == LightType::cylinder && (d.radius == 0 || d.length == 0));
}

// True if the light can be placed. Says why one gives no light.
bool is_usable(const LightDescription& d, const DiagnosticSink& sink, std::vector<std::string>* left_out) {
  if (is_valid_affine(d.light_to_world) && is_within_reach(d.light_to_world)) {
    if (d.intensity != 0 && has_no_size(d))
      report(sink, Severity::warning, "light.size", d.name, "a light of size zero gives no light; give it a size");
    return true;
  }
  const bool near = is_within_reach(d.light_to_world);
  report(sink, near ? Severity::warning : Severity::error, "light.transform", d.name,
         near ? "the transform is not invertible: the light is left out; check its scale"
              : "the transform is not finite, or goes beyond 1e17: the light is left out; move it nearer");
  if (!near) left_out->push_back(d.name);
  return false;
}

void add_lights(const SceneDescription& description, const DiagnosticSink& sink, SceneSnapshot* snapshot) {
  std::vector<Light> lights;
  std::vector<bool> visible;
  for (const auto& d : description.lights) {
    if (!is_usable(d, sink, &snapshot->left_out)) continue;
    lights.push_back(make_light(d, snapshot->origin));
    visible.push_back(d.visible_to_camera);
    snapshot->features.visible_background |= d.type == LightType::dome && d.visible_to_camera;
  }
  for (uint32_t i = 0; i < snapshot->instances.size(); ++i)
    if (emits(snapshot->instances[i])) {
      snapshot->features.emissive_meshes = true;
      // The triangles of what moves are nowhere long enough to be sampled: paths find them by their lobes.
      if (!snapshot->instances[i].is_still()) continue;
      lights.emplace_back(make_mesh_light(snapshot->instances[i], i));
      visible.push_back(true);
    }
  constexpr size_t kSampleAllUpTo = 4;
  snapshot->lights = LightSet(std::move(lights), std::move(visible), kSampleAllUpTo);
}

template <class T>
void sort_unique(std::vector<std::shared_ptr<const T>>* held) {
  std::sort(held->begin(), held->end());
  held->erase(std::unique(held->begin(), held->end()), held->end());
}

void keep_alive(const std::vector<const InstanceDescription*>& drawn, SceneSnapshot* snapshot) {
  for (const InstanceDescription* d : drawn) {
    snapshot->prototypes.push_back(d->prototype);
    snapshot->materials.insert(snapshot->materials.end(), d->materials.begin(), d->materials.end());
  }
  sort_unique(&snapshot->prototypes);
  sort_unique(&snapshot->materials);
  for (const auto& p : snapshot->prototypes) {
    snapshot->memory_bytes +=
        p->mesh.memory_bytes() + p->object->memory_bytes() + p->interior.memory_bytes() + p->tangents.memory_bytes();
    snapshot->features.smooth_normals |= !p->mesh.normals.empty();
  }
  for (const auto& m : snapshot->materials) snapshot->features.textures |= !m->textures.empty();
}

// Materials and lights may share textures: each counts once.
size_t texture_bytes(const SceneSnapshot& snapshot) {
  std::set<const Texture*> textures;
  for (const auto& m : snapshot.materials)
    for (const Texture* texture : m->images()) textures.insert(texture);
  for (const Light& light : snapshot.lights.lights())
    if (const LightImage* image = image_of(light)) textures.insert(image->texture());
  textures.erase(nullptr);
  size_t bytes = 0;
  for (const Texture* texture : textures) bytes += texture->memory_bytes();
  return bytes;
}

// The first middle of a triangle for which the lookup's set of images has none.
std::optional<Vec2f> find_missing_tile(const Instance& instance, const DisneyMaterial* material,
                                       const TextureLookup& lookup) {
  if (!lookup.image || !lookup.image->is_set()) return std::nullopt;
  const Mesh& mesh = instance.prototype->mesh;
  const UvSet* const set = mesh.uv_set(lookup.uv_set);
  for (uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    if (&instance.material(i) != material) continue;
    TriangleHit middle;
    middle.triangle = i, middle.u = middle.v = 1.0f / 3;
    const Vec2f uv = lookup.transform(set ? interpolated<Vec2f>(*set, mesh, middle) : Vec2f(0, 0));
    if (!lookup.image->covers(uv)) return uv;
  }
  return std::nullopt;
}

// Reports, once for all instances of a mesh with a material, the texture coordinates for which a set has no image.
class MissingTiles {
 public:
  MissingTiles(const DiagnosticSink& sink, std::vector<std::string>* faults) : sink_(sink), faults_(faults) {}

  void find(const InstanceDescription& d, const Instance& instance) {
    for (const auto& material : d.materials) {
      if (!seen_.insert({instance.prototype, material.get()}).second) continue;
      for (const MaterialTexture& texture : material->textures) find(d, instance, material.get(), texture.lookup);
      for (const auto* map : {&material->normal_map, &material->coat_normal_map})
        if (*map) find(d, instance, material.get(), **map);
    }
  }

 private:
  void find(const InstanceDescription& d, const Instance& instance, const DisneyMaterial* material,
            const TextureLookup& lookup) {
    const auto uv = find_missing_tile(instance, material, lookup);
    if (!uv) return;
    faults_->push_back(d.name + ": a set of images has none at (" + std::to_string(uv->x) + ", " +
                       std::to_string(uv->y) + ")");
    report(sink_, Severity::error, "texture.tile", d.name, faults_->back());
  }

  const DiagnosticSink& sink_;
  std::vector<std::string>* faults_;
  std::set<std::pair<const MeshPrototype*, const DisneyMaterial*>> seen_;  // instances share both
};

}  // namespace

const Placement& Instance::move_to(float time, std::optional<Placement>* moved) const {
  const Affine map = posed(poses, time);
  return moved->emplace(Placement{map, inverse(map)});
}

bool is_behind(const Instance& instance, const TriangleHit& hit, const Vec3f& dir) {
  if (instance.is_still()) [[likely]] {
    const Mesh& mesh = instance.prototype->mesh;
    const Corners& c = mesh.triangles[hit.triangle];
    const Vec3f n = cross(mesh.points[c[1]] - mesh.points[c[0]], mesh.points[c[2]] - mesh.points[c[0]]);
    return dot(n, instance.world_to_object.vector(dir)) > 0;
  }
  const auto [p0, p1, p2] = instance.prototype->mesh.corners_at(hit.triangle, hit.time);
  std::optional<Placement> moved;
  return dot(cross(p1 - p0, p2 - p0), instance.at(hit.time, &moved).world_to_object.vector(dir)) > 0;
}

std::vector<size_t> scattering_slots(const InstanceDescription& instance) {
  const auto& materials = instance.materials;
  std::vector<size_t> found;
  if (std::none_of(materials.begin(), materials.end(), [](const auto& m) { return m->scatters(); })) return found;
  const auto& slots = instance.prototype->mesh.triangle_material;
  std::vector<bool> used(materials.size(), false);
  if (slots.empty()) used[0] = true;
  for (const int32_t slot : slots) used[static_cast<size_t>(slot) < used.size() ? static_cast<size_t>(slot) : 0] = true;
  for (size_t slot = 0; slot < used.size(); ++slot)
    if (used[slot] && materials[slot]->scatters()) found.push_back(slot);
  return found;
}

std::shared_ptr<const SceneSnapshot> compile_snapshot(const SceneDescription& description, uint64_t number,
                                                      const std::shared_ptr<TraceDevice>& device,
                                                      const DiagnosticSink& sink) {
  auto snapshot = std::make_shared<SceneSnapshot>();
  snapshot->number = number;

  std::vector<const InstanceDescription*> drawn;
  BoundsDouble bounds;
  for (const auto& d : description.instances)
    if (is_drawable(d, sink, &snapshot->left_out)) {
      drawn.push_back(&d);
      bounds.extend(world_bounds(d));
    }
  if (!bounds.empty()) {
    snapshot->origin = bounds.center();
    snapshot->radius = static_cast<float>(0.5 * length(bounds.extent()));
  }

  // Rays come from the scene itself, and from a camera that sees it from some radii away.
  constexpr float kFarthestCamera = 1000;
  std::erase_if(drawn, [&](const InstanceDescription* d) {
    const float farthest = kFarthestCamera * snapshot->radius;
    const auto placed = [&](const Matrix4d& m) { return to_affine(moved_to_render_space(m, snapshot->origin)); };
    std::vector<Affine> poses;
    for (const Matrix4d& pose : d->poses) poses.push_back(placed(pose));
    if (is_traceable(placed(d->object_to_world), farthest) && (poses.empty() || is_traceable(poses, farthest)))
      return false;
    leave_out(*d, "beside the size of the scene the transform makes it too small, flat or large to be traced", sink,
              &snapshot->left_out);
    return true;
  });

  std::vector<InstancePlacement> placements;
  MissingTiles missing_tiles(sink, &snapshot->faults);
  for (const InstanceDescription* d : drawn) {
    snapshot->instances.push_back(place(*d, snapshot->origin));
    missing_tiles.find(*d, snapshot->instances.back());
    snapshot->features.see_through |= snapshot->instances.back().see_through;
    const Instance& instance = snapshot->instances.back();
    snapshot->features.motion |= !instance.is_still();
    placements.push_back({d->prototype->object, instance.object_to_world, instance.poses});
    if (has_clear_interior(*d)) snapshot->clear_bodies.extend(bounds_in_render_space(instance));
  }
  snapshot->top = build_instanced_scene(device, placements);
  if (!snapshot->top || !plan_bodies(drawn, device, snapshot.get())) return nullptr;
  snapshot->memory_bytes += snapshot->top->memory_bytes();
  keep_alive(drawn, snapshot.get());
  add_lights(description, sink, snapshot.get());
  find_lit_surfaces(snapshot.get());
  snapshot->memory_bytes += snapshot->lights.memory_bytes() + texture_bytes(*snapshot);
  return snapshot;
}

}  // namespace alabaster
