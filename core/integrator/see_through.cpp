#include "core/integrator/see_through.h"

#include <algorithm>
#include <cmath>
#include <new>

#include "core/integrator/vertex.h"
#include "core/subsurface/body.h"

namespace alabaster {
namespace {

constexpr double kUnit = 0x1p32;
constexpr int64_t kBlack = int64_t(-200) << 32;  // below the smallest float

// As is_behind(), of a hit that a ray along `dir` has found: without a look at the triangle, which is far away.
bool is_found_behind(const Instance& instance, const TriangleHit& hit, const Vec3f& dir) {
  if (instance.stands_alone()) [[likely]]
    return dot(hit.normal, instance.world_to_object.vector(dir)) > 0;
  std::optional<Placement> moved;
  return dot(hit.normal, instance.at(hit, &moved).world_to_object.vector(dir)) > 0;
}

// Transmittance where only the instances of which `casts` is true cast shadows.
template <class Casts>
class SomeTransmittance final : public HitFilter {
 public:
  SomeTransmittance(const PathContext& context, const Vec3f& dir, const MediumStack& media, const Casts& casts)
      : all_(context, dir, media), scene_(context.scene), casts_(casts) {}
  bool stops(const TriangleHit& hit) const noexcept override {
    return casts_(scene_.instance(hit.instance)) && all_.stops(hit);
  }
  Rgb value() const { return all_.value(); }

 private:
  const Transmittance all_;
  const SceneSnapshot& scene_;
  const Casts& casts_;
};

template <class Casts>
Rgb visibility_among(const PathContext& context, const Ray& ray, const MediumStack& media, const Casts& casts) {
  const SomeTransmittance transmittance(context, ray.dir, media, casts);
  return context.scene.top->occluded(ray, &transmittance) ? Rgb(0.0f) : transmittance.value();
}

// What goes straight on through a surface that was hit. Black but for clear sheets.
Rgb straight_through(const PathContext& context, const Vec3f& dir, const TriangleHit& hit, const MediumStack& media) {
  const DisneyParameters& constants = context.scene.instance(hit.instance).material(hit.triangle).constants;
  if (!constants.thin || !(constants.spec_trans > 0)) return Rgb(0.0f);
  Vertex v;
  evaluate_surface(context, {{0, 0, 0}, dir, hit.t, hit.time}, hit, 0, &v);
  const InterfaceSide side{v.material.ior / media.index(), false};
  return DisneyTransmissiveBsdf(v.material, v.frame.to_local(-dir), side, context.settings.energy).straight();
}

// A wall of a union with holes that lies within another member: no surface of the body.
bool is_within_union(const Instance& instance, const DisneyMaterial& material, const Vec3f& dir,
                     const TriangleHit& hit) {
  const SubsurfaceBody* const body = instance.body;
  if (!body || !body->is_union() || !material.is_partly_opaque()) return false;
  const uint8_t flags = body->members[instance.member].shells->flags(hit.triangle);
  return !(flags & (MeshShells::kOpen | MeshShells::kInner)) && body->is_inner_wall(instance.member, hit, dir);
}

}  // namespace

bool is_culled(const Instance& instance, const TriangleHit& hit, const Vec3f& dir) {
  const CameraCull cull = instance.options.camera_cull;
  return cull == CameraCull::all ||
         (cull != CameraCull::none && is_found_behind(instance, hit, dir) == (cull == CameraCull::back));
}

bool is_in_union(const SceneSnapshot& scene, const MediumStack& interiors, const Instance& member) {
  if (!member.body || !member.body->is_union()) return false;
  for (uint32_t i = 0; i < interiors.size(); ++i)
    if (scene.instance(interiors[i].instance).body == member.body) return true;
  return false;
}

namespace {

// coverage_at() of a partly opaque material. Not inlined: other hits need no stack frame.
[[gnu::noinline]] float partial_coverage(const SceneSnapshot& scene, const Vec3f& dir, const TriangleHit& hit,
                                         const MediumStack* within) {
  const Instance& instance = scene.instance(hit.instance);
  const DisneyMaterial& material = instance.material(hit.triangle);
  if (within && (within->contains(hit.instance) || is_in_union(scene, *within, instance))) return 1;
  if (is_within_union(instance, material, dir, hit)) return 0;
  const Mesh& mesh = instance.prototype->mesh;
  const Vec2f uv = mesh.uv_sets.empty() ? Vec2f(0, 0) : interpolated<Vec2f>(mesh.uv_sets.front(), mesh, hit);
  return material.coverage(instance.primvars_at(hit, uv));
}

}  // namespace

float coverage_at(const SceneSnapshot& scene, const Vec3f& dir, const TriangleHit& hit, const MediumStack* within) {
  const Instance& instance = scene.instance(hit.instance);
  if (!instance.see_through) return 1;
  const size_t slot = instance.slot(hit.triangle);
  if (instance.is_single_sided(slot) && is_found_behind(instance, hit, dir)) return 0;
  return instance.materials[slot]->is_partly_opaque() ? partial_coverage(scene, dir, hit, within) : 1;
}

uint32_t air_pocket_of(const SceneSnapshot& scene, uint32_t instance) {
  const SubsurfaceBody* const body = scene.instance(instance).body;
  return body && body->is_union() ? body->members.front().instance : instance;
}

Crossing crossing_at(const Instance& instance, const Vec3f& dir, const TriangleHit& hit) {
  bool leaves = false;
  if (instance.body) {
    if (instance.body->members[instance.member].shells->flags(hit.triangle) & (MeshShells::kOpen | MeshShells::kInner))
      return Crossing::none;
    if (is_within_union(instance, instance.material(hit.triangle), dir, hit)) return Crossing::none;
    leaves = instance.body->leaves(instance.member, hit, dir);
  } else {
    const DisneyMaterial& material = instance.material(hit.triangle);
    if (!material.transmits() || material.constants.thin || !instance.prototype->mesh.closed) return Crossing::none;
    leaves = is_found_behind(instance, hit, dir);
  }
  return leaves ? Crossing::leaves : Crossing::enters;
}

bool StochasticStop::stops(const TriangleHit& hit) const noexcept {
  const bool culled = depth_ == 0 && is_culled(scene_.instance(hit.instance), hit, dir_);
  const float coverage = culled ? 0 : coverage_at(scene_, dir_, hit, &within_);
  if (coverage >= 1) return true;
  if (coverage > 0) {
    const uint32_t number = sampler_.number(Dimension::opacity, depth_);
    if (to_unit_float(hash_combine(hash_combine(number, hit.instance), hit.triangle)) < coverage) return true;
  }
  note_hole(hit);
  return false;
}

void StochasticStop::note_hole(const TriangleHit& hit) const {
  const Crossing crossing = crossing_at(scene_.instance(hit.instance), dir_, hit);
  if (crossing == Crossing::none) return;
  for (uint32_t i = 0; i < holes_.size(); ++i)
    if (holes_[i].instance == hit.instance && holes_[i].triangle == hit.triangle) return;
  try {
    holes_.push({hit.t, hit.instance, hit.triangle, crossing});
  } catch (const std::bad_alloc&) {  // Embree's callbacks let none through; the path will ask for memory as well
  }
}

void StochasticStop::cross_holes(float t, AirPockets* hollows) const {
  // Holes are found in no order. Entries come first, because a ray may leave a body that it has entered.
  for (const Crossing crossing : {Crossing::enters, Crossing::leaves})
    for (uint32_t i = 0; i < holes_.size(); ++i) {
      if (holes_[i].crossing != crossing || !(holes_[i].t < t)) continue;
      if (crossing == Crossing::enters)
        hollows->enter(air_pocket_of(scene_, holes_[i].instance));
      else
        hollows->leave(air_pocket_of(scene_, holes_[i].instance));
    }
}

bool StochasticStop::uncross_holes(AirPockets* hollows) const {
  for (uint32_t i = 0; i < holes_.size(); ++i) {
    const uint32_t pocket = air_pocket_of(scene_, holes_[i].instance);
    if (holes_[i].crossing == Crossing::enters)
      hollows->leave(pocket);
    else if (!hollows->contains(pocket))
      hollows->enter(pocket);
  }
  return holes_.size() > 0;
}

bool Transmittance::stops(const TriangleHit& hit) const noexcept {
  const float coverage = coverage_at(context_.scene, dir_, hit, &media_);
  const Rgb straight =
      coverage > 0 && context_.scene.features.clear_sheets ? straight_through(context_, dir_, hit, media_) : Rgb(0.0f);
  if (coverage >= 1 && is_black(straight)) return true;
  bool any = false;
  int64_t step = 0;
  for (int c = 0; c < 3; ++c) {
    if (c == 0 || straight[c] != straight[c - 1]) {  // channels are mostly alike
      const double passed = 1.0 - double(coverage) * (1.0 - double(straight[c]));
      step = passed > 0 ? static_cast<int64_t>(std::llrint(std::log2(passed) * kUnit)) : kBlack;
    }
    int64_t& log = log_[static_cast<size_t>(c)];
    log = std::max(log + step, kBlack);
    any = any || log > kBlack;
  }
  return !any;
}

Rgb Transmittance::value() const {
  Rgb value(1.0f);
  for (int c = 0; c < 3; ++c) {
    const int64_t log = log_[static_cast<size_t>(c)];
    if (log != 0) value[c] = log > kBlack ? static_cast<float>(std::exp2(static_cast<double>(log) / kUnit)) : 0;
  }
  return value;
}

Rgb linked_visibility(const PathContext& context, const Ray& ray, uint32_t shadow_link, const MediumStack& media) {
  return visibility_among(context, ray, media,
                          [&](const Instance& instance) { return context.scene.casts_shadow(instance, shadow_link); });
}

Rgb visibility_among_catchers(const PathContext& context, const Ray& ray, uint32_t shadow_link,
                              const MediumStack& media) {
  return visibility_among(context, ray, media, [&](const Instance& instance) {
    return instance.options.shadow_catcher && context.scene.casts_shadow(instance, shadow_link);
  });
}

}  // namespace alabaster
