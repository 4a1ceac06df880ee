#include "core/scene/snapshot_compiler.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "core/diagnostics/plain_format.h"
#include "core/scene/bodies.h"
#include "core/scene/clear_bodies.h"
#include "core/scene/contents.h"
#include "core/scene/lit_surfaces.h"
#include "core/scene/missing_tiles.h"
#include "core/scene/scene_origin.h"
#include "core/scene/scene_reports.h"
#include "core/scene/snapshot_lights.h"
#include "core/scene/world_placement.h"

namespace alabaster {
namespace {

BoundsDouble world_bounds(const InstanceDescription& d) {
  const Bounds& object = d.prototype->mesh.bounds;
  BoundsDouble world = world_bounds(object, d.object_to_world);
  for (const Matrix4d& pose : d.poses) world.extend(world_bounds(object, pose));
  return world;
}

// The rest of the scene is drawn without an instance that cannot be placed or traced. It is an error unless the
// instance has no extent.
void leave_out(const InstanceDescription& d, const char* reason, const DiagnosticSink& sink,
               std::vector<std::string>* left_out) {
  const auto reaches = [](const Matrix4d& m) { return is_within_reach(m); };
  const bool near = reaches(d.object_to_world) && std::all_of(d.poses.begin(), d.poses.end(), reaches);
  report(sink, near ? Severity::warning : Severity::error, "instance.transform", d.name,
         std::string(reason) + ": the instance is left out; check its " + (near ? "scale" : "transform"));
  if (!near) left_out->push_back(d.name);
}

bool has_shape(const InstanceDescription& d) {
  return d.prototype && d.prototype->object && !d.prototype->mesh.triangles.empty() && !d.materials.empty();
}

// Where it stands; none: it is not drawn.
std::optional<BoundsDouble> drawn_bounds(const InstanceDescription& d, const DiagnosticSink& sink,
                                         std::vector<std::string>* left_out) {
  if (!has_shape(d)) return std::nullopt;
  if (!is_valid_affine(d.object_to_world) || !std::all_of(d.poses.begin(), d.poses.end(), is_valid_affine)) {
    leave_out(d, "the transform is not finite, not affine or not invertible in single precision", sink, left_out);
    return std::nullopt;
  }
  const BoundsDouble bounds = world_bounds(d);
  if (is_within_reach(bounds)) return bounds;
  leave_out(d, "the transform takes it beyond 1e17", sink, left_out);
  return std::nullopt;
}

// To the farthest corner.
float radius_about(const Vec3d& origin, const BoundsDouble& bounds) {
  if (bounds.empty()) return 0;
  const Vec3d half = bounds.extent() * 0.5, shift = bounds.center() - origin;
  return static_cast<float>(length(half + Vec3d(std::abs(shift.x), std::abs(shift.y), std::abs(shift.z))));
}

bool is_single_sided(const InstanceDescription& d, const DisneyMaterial& material) {
  const Sides sides = material.constants.sides;
  return sides == Sides::mesh ? !d.options.double_sided : sides == Sides::front;
}

// Rays get behind a closed mesh of opaque faces, which are there from their fronts alone, where they begin there, or
// not at all.
bool shows_fronts_alone(const Instance& i) {
  const auto lets_in = [](const DisneyMaterial* m) { return m->is_partly_opaque() || m->is_translucent(); };
  return i.single_sided && i.prototype->mesh.outward && i.options.camera_cull == CameraCull::none &&
         std::none_of(i.materials.begin(), i.materials.end(), lets_in);
}

// All but where it stands.
Instance look_of(const InstanceDescription& d) {
  Instance instance;
  instance.prototype = d.prototype.get();
  instance.slots = &d.triangle_slots();
  instance.prim_id = d.prim_id;
  instance.instance_id = d.instance_id;
  instance.category_set = d.category_set;
  instance.light_group = d.light_group;
  instance.values = d.values;
  bool has_maps = false;
  for (size_t slot = 0; slot < d.materials.size(); ++slot) {
    const DisneyMaterial& material = *d.materials[slot];
    instance.materials.push_back(&material);
    const bool single_sided = is_single_sided(d, material) && !material.is_translucent();
    instance.see_through |= material.is_partly_opaque() || single_sided;
    if (single_sided) {
      instance.single_sided = true;
      instance.single_sided_slots.resize(d.materials.size());
      instance.single_sided_slots[slot] = 1;
    }
    for (const auto* map : {&material.normal_map, &material.coat_normal_map}) {
      if (!*map || (*map)->is_bump) continue;
      const auto of = d.prototype->tangents.of(d.prototype->mesh, (*map)->primvar, (*map)->transform.axes());
      if (!std::exchange(has_maps, true)) instance.tangents = of;
      if (of != instance.tangents) instance.own_tangents.emplace_back(&**map, of);
    }
  }
  std::sort(instance.own_tangents.begin(), instance.own_tangents.end());
  instance.options = d.options;
  if (!d.options.visible_to_camera) instance.options.camera_cull = CameraCull::all;
  instance.see_through |= instance.options.camera_cull != CameraCull::none;
  return instance;
}

bool has_ends(const InstanceDescription& d) {
  return d.mesh_ends || !d.ends.empty();
}

Instance place(const InstanceDescription& d, const Vec3d& origin) {
  const Matrix4d m = moved_to(d.object_to_world, origin);
  Instance instance = look_of(d);
  instance.object_to_world = to_affine(m);
  instance.world_to_object = to_affine(m.inverse());
  for (const Matrix4d& pose : d.poses) instance.poses.push_back(to_affine(moved_to(pose, origin)));
  if (has_ends(d)) {
    const auto end = [&](size_t i) {
      return d.ends.empty() ? instance.object_to_world : to_affine(moved_to(d.ends[i], origin));
    };
    instance.ends = std::make_shared<const InstanceEnds>(InstanceEnds{{end(0), end(1)}, d.mesh_ends});
  }
  return instance;
}

// Instances of one mesh come one after the other.
std::vector<PlacedSize> placed_sizes(const std::vector<const InstanceDescription*>& drawn) {
  std::vector<PlacedSize> all;
  all.reserve(drawn.size());
  MiddleHalf middle;
  const MeshPrototype* last = nullptr;
  for (const InstanceDescription* d : drawn) {
    if (d->prototype.get() != last) middle = middle_half(d->prototype->mesh), last = d->prototype.get();
    all.push_back(placed_size(middle, d->object_to_world));
  }
  return all;
}

// Each placement in an array depends on the origin: it stays while the bounds of the scene change a little.
Vec3d snapped(const Vec3d& origin, float radius) {
  if (!(radius > 0)) return origin;
  const double step = std::ldexp(1.0, std::ilogb(radius) - 3);
  return {std::round(origin.x / step) * step, std::round(origin.y / step) * step, std::round(origin.z / step) * step};
}

bool are_placed_alike(const InstanceArray& a, const InstanceArray& b) {
  return a.first == b.first && a.placed->traced.slots == b.placed->traced.slots &&
         a.placed->traced.cells == b.placed->traced.cells;
}

// Instances of one mesh come one after the other.
bool is_made_as(const InstanceDescription& a, const InstanceDescription& b) {
  return a.prototype == b.prototype && a.materials == b.materials && a.slots == b.slots;
}

template <class T>
void sort_unique(std::vector<std::shared_ptr<const T>>* held) {
  std::sort(held->begin(), held->end());
  held->erase(std::unique(held->begin(), held->end()), held->end());
}

void keep_alive(const DrawnInstances& drawn, SceneSnapshot* snapshot) {
  for (const auto* list : {&drawn.alone, &drawn.looks})
    for (size_t i = 0; i < list->size(); ++i) {
      const InstanceDescription* const d = (*list)[i];
      if (i > 0 && is_made_as(*(*list)[i - 1], *d)) continue;
      snapshot->prototypes.push_back(d->prototype);
      if (d->slots) snapshot->slots.push_back(d->slots);
      snapshot->materials.insert(snapshot->materials.end(), d->materials.begin(), d->materials.end());
    }
  sort_unique(&snapshot->prototypes);
  sort_unique(&snapshot->materials);
  sort_unique(&snapshot->slots);
  for (const auto& slots : snapshot->slots) snapshot->memory_bytes += slots->capacity() * sizeof((*slots)[0]);
  for (const auto& p : snapshot->prototypes) {
    snapshot->memory_bytes +=
        p->mesh.memory_bytes() + p->object->memory_bytes() + p->interior.memory_bytes() + p->tangents.memory_bytes();
  }
  for (const auto& m : snapshot->materials) snapshot->features.textures |= !m->textures.empty();
}

// Materials and lights may share textures: each counts once.
size_t texture_bytes(const SceneSnapshot& snapshot) {
  std::set<const Texture*> textures;
  for (const auto& m : snapshot.materials)
    for (const Texture* texture : m->images()) textures.insert(texture);
  for (const Light& light : snapshot.lights.lights())
    if (const auto image = image_of(light)) textures.insert(image->texture());
  textures.erase(nullptr);
  std::map<const void*, size_t> bytes;  // by texels
  for (const Texture* texture : textures) bytes[texture->texels()] = texture->memory_bytes();
  return std::accumulate(bytes.begin(), bytes.end(), size_t(0),
                         [](size_t sum, const auto& one) { return sum + one.second; });
}

bool stands_alike(const Instance& a, const Instance& b) {
  return a.prototype->object == b.prototype->object && a.object_to_world == b.object_to_world && a.poses == b.poses;
}

}  // namespace

struct SnapshotCompiler::Compilation {
  SnapshotCompiler& compiler;
  const SceneDescription& description;
  const CancelToken& cancel;
  const SceneSnapshot* const last = compiler.last_.get();
  std::shared_ptr<SceneSnapshot> snapshot = std::make_shared<SceneSnapshot>();
  std::vector<const InstanceDescription*> drawn = {};
  std::deque<InstanceDescription> taken_apart = {};    // arrays that cannot be traced as such
  std::vector<ArrayPlan> plans = {};                   // of the arrays
  std::vector<const InstanceDescription*> looks = {};  // theirs
  std::vector<Diagnostic> faults = {};                 // of bodies
  ArrayNeighbours neighbours{description};

  // In world space, then beside the scene's size.
  void choose_drawn() {
    BoundsDouble bounds;
    for (const auto& d : description.instances)
      if (const auto own = drawn_bounds(d, compiler.sink_, &snapshot->left_out)) {
        drawn.push_back(&d);
        bounds.extend(*own);
      }
    for (const InstanceArrayDescription& array : description.arrays) {
      if (!has_shape(array.look)) continue;
      in_name_of(array.look.name, [&] { stays_array(array) ? plan(array, &bounds) : take_apart(array, &bounds); });
    }
    choose_space(bounds);
    std::erase_if(drawn, [&](const InstanceDescription* d) {
      if (is_seen_traceably(*d)) return false;
      leave_out(*d, "beside the size of the scene the transform makes it too small, flat or large to be traced",
                compiler.sink_, &snapshot->left_out);
      return true;
    });
  }

  // False for emissive meshes, members of unions, and bodies that something stands in: lights and bodies refer to
  // single instances.
  bool stays_array(const InstanceArrayDescription& array) {
    const InstanceDescription& look = array.look;
    const auto emits = [](const auto& material) { return material->emits(); };
    return !look.prototype->mesh.deforms() && std::none_of(look.materials.begin(), look.materials.end(), emits) &&
           scatter_separately(look, cancel) && !(is_cloudy(look) && neighbours.any_in(array, cancel));
  }

  void take_apart(const InstanceArrayDescription& array, BoundsDouble* bounds) {
    for (size_t i = 0; i < array.places->size(); ++i) {
      if (i % 1024 == 0) cancel.check();
      auto instance = array.instance(i);
      if (!instance) continue;
      const auto own = drawn_bounds(*instance, compiler.sink_, &snapshot->left_out);
      if (!own) continue;
      drawn.push_back(&taken_apart.emplace_back(std::move(*instance)));
      bounds->extend(*own);
    }
  }

  void plan(const InstanceArrayDescription& array, BoundsDouble* bounds) {
    const PlacedArray* const known = find_last(array.look);
    plans.push_back(plan_array(array, known ? &known->plan : nullptr, memory_of(*compiler.device_), cancel));
    looks.push_back(&array.look);
    for (const auto& block : plans.back().blocks) bounds->extend(block->bounds);
  }

  // Meshes of equal geometry have one prototype.
  const PlacedArray* find_last(const InstanceDescription& look) const {
    if (!last) return nullptr;
    const PlacedArray* any = nullptr;
    for (const InstanceArray& array : last->arrays) {
      if (array.look.prototype != look.prototype.get()) continue;
      if (array.look.prim_id == look.prim_id) return array.placed.get();
      any = array.placed.get();
    }
    return any;
  }

  using Blocks = std::set<const ArrayBlock*>;
  struct NamedSizes {
    std::vector<PlacedSize> sizes;
    std::vector<const std::string*> names;  // parallel
    std::vector<const ArrayBlock*> blocks;  // parallel; null: of one instance
  };
  // Blocks of arrays count as one, unless they are in `apart`.
  NamedSizes sizes_of_all(const Blocks& apart) const {
    NamedSizes all{placed_sizes(drawn), {}, {}};
    for (const InstanceDescription* d : drawn) all.names.push_back(&d->name);
    all.blocks.resize(drawn.size(), nullptr);
    for (size_t i = 0; i < plans.size(); ++i)
      for (size_t b = 0; b < plans[i].blocks.size(); ++b) {
        cancel.check();
        const ArrayBlock* const block = plans[i].blocks[b].get();
        if (block->size.count == 0) continue;
        const bool is_apart = apart.contains(block);
        const auto sizes = is_apart ? sizes_in(plans[i], b) : std::vector<PlacedSize>{block->size};
        all.sizes.insert(all.sizes.end(), sizes.begin(), sizes.end());
        all.names.resize(all.sizes.size(), &looks[i]->name);
        all.blocks.resize(all.sizes.size(), is_apart ? nullptr : block);
      }
    return all;
  }

  // A block that might be too far away for its smallest instance is looked at by instance.
  void choose_space(const BoundsDouble& bounds) {
    Blocks apart;
    NamedSizes all;
    SceneOrigin chosen;
    for (bool decided = false; !decided;) {
      all = sizes_of_all(apart);
      chosen = choose_origin(all.sizes, bounds);
      decided = true;
      for (const size_t i : chosen.too_far)
        if (all.blocks[i]) apart.insert(all.blocks[i]), decided = false;
    }
    snapshot->origin = chosen.origin;
    if (!plans.empty() && chosen.is_center) {
      const Vec3d near = snapped(chosen.origin, radius_about(chosen.origin, bounds));
      if (count_too_far(all.sizes, near) == 0) snapshot->origin = near;
    }
    snapshot->radius = radius_about(snapshot->origin, bounds);
    check_scale(snapshot->radius, all.sizes);
    if (!chosen.too_far.empty())
      report(compiler.sink_, Severity::warning, "scene.far", *all.names[chosen.too_far.front()],
             std::to_string(chosen.too_far.size()) +
                 " of the scene's instances, this one first, stand a million times their size away from the scene's "
                 "middle: their shapes lose detail to rounding; move them nearer, or render them by themselves");
  }

  void check_scale(float radius, const std::vector<PlacedSize>& sizes) {
    if (radius == 0 || (radius >= kLeastRadius && radius <= kLargestRadius)) return;
    const auto is_small = [](const PlacedSize& placed) { return placed.size < kSmallInHuge; };
    if (radius > kLargestRadius && std::any_of(sizes.begin(), sizes.end(), is_small)) return;
    snapshot->faults.push_back(plain_format(
        "the scene has a radius of %.3g units, and renders right from %.3g to %.3g: scale it, with its lights "
        "and camera (metersPerUnit, or the scale of its placement), or leave out what lies far away",
        double(radius), double(kLeastRadius), double(kLargestRadius)));
    report(compiler.sink_, Severity::error, "scene.scale", "", snapshot->faults.back());
  }

  // Rays come from the scene itself, and from a camera that sees it from some radii away.
  float farthest_ray() const {
    constexpr float kFarthestCamera = 1000;
    return std::min(kFarthestCamera * snapshot->radius, kTraceLimit / 4);
  }

  bool is_seen_traceably(const InstanceDescription& d) const {
    const float farthest = farthest_ray();
    const auto placed = [&](const Matrix4d& m) { return to_affine(moved_to(m, snapshot->origin)); };
    std::vector<Affine> poses;
    for (const Matrix4d& pose : d.poses) poses.push_back(placed(pose));
    return is_traceable(placed(d.object_to_world), farthest) && (poses.empty() || is_traceable(poses, farthest));
  }

  // The instances, and so many bytes of lights.
  void hold(size_t light_bytes) {
    const auto ends = std::count_if(drawn.begin(), drawn.end(), [](const auto* d) { return has_ends(*d); });
    snapshot->memory->resize(
        drawn.size() * sizeof(Instance) + static_cast<size_t>(ends) * sizeof(InstanceEnds) + light_bytes,
        "a scene of " + std::to_string(drawn.size()) + " instances and " + std::to_string(description.lights.size()) +
            " lights");
  }

  bool place_all() {
    snapshot->memory = std::make_shared<MemoryReservation>(memory_of(*compiler.device_), MemoryUse::scene);
    MissingTiles missing_tiles(compiler.sink_, &snapshot->faults);
    hold(0);
    snapshot->instances.reserve(drawn.size());
    const InstanceDescription* before = nullptr;
    for (const InstanceDescription* d : drawn) {
      Instance instance;
      in_name_of(d->name, [&] { instance = place(*d, snapshot->origin); });
      if (!before || !is_made_as(*d, *before)) missing_tiles.find(*d, instance);
      before = d;
      snapshot->features.see_through |= instance.see_through && !shows_fronts_alone(instance);
      snapshot->features.clear_sheets |= has_clear_sheets(instance);
      snapshot->features.shadow_catchers |= instance.options.shadow_catcher;
      snapshot->features.motion |= !instance.is_still();
      if (has_clear_interior(instance)) snapshot->clear_bodies.extend(bounds_in_render_space(instance));
      snapshot->instances.push_back(std::move(instance));
    }
    return place_arrays(&missing_tiles);
  }

  bool place_arrays(MissingTiles* missing_tiles) {
    snapshot->arrays.reserve(plans.size());
    for (size_t i = 0; i < plans.size(); ++i) {
      const InstanceDescription& d = *looks[i];
      std::shared_ptr<const PlacedArray> placed;
      Instance look;
      in_name_of(d.name, [&] {
        look = look_of(d);
        const RenderSpace space{snapshot->origin, farthest_ray()};
        placed = place_array(std::move(plans[i]), space, find_last(d), compiler.device_, cancel);
      });
      if (!placed) return false;
      if (report_left_out(*placed, d.name, compiler.sink_)) snapshot->left_out.push_back(d.name);
      snapshot->memory_bytes += placed->memory_bytes();
      const auto first = static_cast<uint32_t>(snapshot->instance_count());
      InstanceArray& array = snapshot->arrays.emplace_back(InstanceArray{std::move(look), first, std::move(placed)});
      array.look.array = &array;
      missing_tiles->find(d, array.look);
      snapshot->features.see_through |= array.look.see_through && !shows_fronts_alone(array.look);
      snapshot->features.clear_sheets |= has_clear_sheets(array.look);
      snapshot->features.shadow_catchers |= array.look.options.shadow_catcher;
      if (has_clear_interior(array.look)) snapshot->clear_bodies.extend(array.placed->bounds());
    }
    return true;
  }

  bool build_top() {
    const auto& instances = snapshot->instances;
    if (last &&
        std::equal(instances.begin(), instances.end(), last->instances.begin(), last->instances.end(), stands_alike) &&
        std::equal(snapshot->arrays.begin(), snapshot->arrays.end(), last->arrays.begin(), last->arrays.end(),
                   are_placed_alike)) {
      snapshot->top = last->top;
    } else {
      std::vector<InstancePlacement> placements;
      placements.reserve(drawn.size());
      for (size_t i = 0; i < drawn.size(); ++i)
        placements.push_back({drawn[i]->prototype->object, instances[i].object_to_world, instances[i].poses});
      std::vector<InstanceCells> arrays;
      for (const InstanceArray& array : snapshot->arrays) arrays.push_back(array.placed->traced);
      snapshot->top = build_instanced_scene(
          compiler.device_, placements, [this] { return cancel.is_cancelled(); }, arrays);
      if (!snapshot->top) cancel.check();
    }
    if (snapshot->top) snapshot->memory_bytes += snapshot->top->memory_bytes();
    return snapshot->top != nullptr;
  }

  // True if all lights are those of `last`.
  bool light() {
    const bool described_alike =
        description.lights == compiler.last_lights_ && description.category_sets == compiler.last_category_sets_;
    const bool same = add_lights(
        {description, {drawn, looks}, last, described_alike, compiler.device_, compiler.sink_, cancel}, snapshot.get());
    size_t bytes = snapshot->lights.memory_bytes();  // without what has reservations of its own
    for (const Light& light : snapshot->lights.lights()) {
      if (const auto image = image_of(light)) bytes -= image->memory_bytes();
      if (const auto* mesh = std::get_if<MeshLight>(&light)) bytes -= mesh->memory_bytes();
    }
    hold(bytes);
    return same;
  }

  bool are_linked_alike() const {
    const auto same = [](const Instance& a, const Instance& b) { return a.category_set == b.category_set; };
    const auto same_looks = [&](const InstanceArray& a, const InstanceArray& b) { return same(a.look, b.look); };
    return std::equal(snapshot->instances.begin(), snapshot->instances.end(), last->instances.begin(),
                      last->instances.end(), same) &&
           std::equal(snapshot->arrays.begin(), snapshot->arrays.end(), last->arrays.begin(), last->arrays.end(),
                      same_looks);
  }

  bool run(uint64_t number) {
    snapshot->number = number;
    snapshot->light_groups = description.light_groups;
    choose_drawn();
    cancel.check();
    if (!place_all()) return false;
    cancel.check();
    const bool same_lights = light();
    if (!plan_bodies({{drawn, looks}, compiler.device_, last, cancel}, snapshot.get())) return false;
    cancel.check();
    if (!build_top()) return false;
    cancel.check();
    keep_alive({drawn, looks}, snapshot.get());
    const DiagnosticSink keep = [&](const Diagnostic& d) { faults.push_back(d); };
    const DrawnInstances all{drawn, looks};
    const ReportedScene reported{description, all, *snapshot, keep, cancel};
    if (snapshot->features.subsurface) report_bodies(reported);
    report_lights_without_size(reported);
    const bool alike = same_lights && snapshot->top == last->top && are_linked_alike();
    plan_lit_surfaces(alike ? last : nullptr, snapshot.get());
    snapshot->memory_bytes += snapshot->lights.memory_bytes() + texture_bytes(*snapshot);
    return true;
  }
};

std::shared_ptr<const SceneSnapshot> SnapshotCompiler::compile(const SceneDescription& description, uint64_t number,
                                                               const CancelToken& cancel) {
  Compilation compilation{*this, description, cancel};
  std::vector<LightParameters> lights = description.lights;
  auto category_sets = description.category_sets;
  if (!compilation.run(number)) return nullptr;
  const auto is_known = [&](const Diagnostic& d) {
    return std::any_of(reported_.begin(), reported_.end(),
                       [&](const Diagnostic& t) { return t.code == d.code && t.where == d.where && t.text == d.text; });
  };
  for (const Diagnostic& d : compilation.faults)
    if (sink_ && !is_known(d)) sink_(d);
  reported_ = std::move(compilation.faults);
  last_lights_ = std::move(lights);
  last_category_sets_ = std::move(category_sets);
  return last_ = std::move(compilation.snapshot);
}

std::shared_ptr<const SceneSnapshot> compile_snapshot(const SceneDescription& description, uint64_t number,
                                                      const std::shared_ptr<TraceDevice>& device,
                                                      const DiagnosticSink& sink) {
  return SnapshotCompiler(device, sink).compile(description, number);
}

}  // namespace alabaster
