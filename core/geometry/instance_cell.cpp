#include "core/geometry/instance_cell.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/geometry/embree_instance_cell.h"
#include "core/math/bounds.h"

namespace alabaster {
namespace {

RTCRay carried(RTCRay ray, const Affine& map) {
  const Vec3f o = map.point({ray.org_x, ray.org_y, ray.org_z}), d = map.vector({ray.dir_x, ray.dir_y, ray.dir_z});
  ray.org_x = o.x, ray.org_y = o.y, ray.org_z = o.z;
  ray.dir_x = d.x, ray.dir_y = d.y, ray.dir_z = d.z;
  return ray;
}

// The bounds of the object where it stands. The ray that meets the object's own bounds is carried there in float: wider
// by what that may round.
Bounds placed_bounds(RTCScene object, const Placement& placement) {
  RTCBounds own;
  rtcGetSceneBounds(object, &own);
  const Bounds box{{own.lower_x, own.lower_y, own.lower_z}, {own.upper_x, own.upper_y, own.upper_z}};
  Bounds placed;
  if (box.empty()) return placed;
  for (const Vec3f& corner : box.corners()) placed.extend(placement.object_to_world.point(corner));
  const float largest = std::max(max_abs_component(placed.lower), max_abs_component(placed.upper));
  const Vec3f margin(8 * std::numeric_limits<float>::epsilon() * largest);
  return {placed.lower - margin, placed.upper + margin};
}

// The context of a ray while it is in one instance: hits then carry the instance's index.
class InstanceScope {
 public:
  InstanceScope(RayContext* context, uint32_t number) : context_(*context) {
    context_.instID[0] = filter_context(context)->first + number;
  }
  ~InstanceScope() { context_.instID[0] = RTC_INVALID_GEOMETRY_ID; }
  InstanceScope(const InstanceScope&) = delete;
  InstanceScope& operator=(const InstanceScope&) = delete;
  uint32_t index() const { return context_.instID[0]; }

 private:
  RayContext& context_;
};

}  // namespace

EmbreeInstanceCell::EmbreeInstanceCell(std::shared_ptr<TraceDevice> device, std::shared_ptr<const ObjectScene> object,
                                       CellInstances instances)
    : InstanceCell(std::move(instances)),
      object_(std::move(object)),
      scene_(std::move(device), "a hierarchy of instances") {
  // Half the memory, and no triangles that would be traced slower.
  if (scene_.get()) rtcSetSceneFlags(scene_.get(), rtcGetSceneFlags(scene_.get()) | RTC_SCENE_FLAG_COMPACT);
  for (size_t i = 0; i < instances_.placements.size(); ++i)
    if (!instances_.hidden[i]) growth_.include(RayGrowth::of(instances_.placements[i].object_to_world));
}

bool EmbreeInstanceCell::build(const std::function<bool()>& cancelled) {
  return scene_.get() && attach(scene_, {this, instances_.placements.size(), &bound, &intersect, &occluded}) &&
         commit(scene_.get(), cancelled);
}

void EmbreeInstanceCell::bound(const RTCBoundsFunctionArguments* args) noexcept {
  const auto& cell = *static_cast<const EmbreeInstanceCell*>(args->geometryUserPtr);
  Bounds bounds;  // Embree leaves out what is empty
  if (!cell.instances_.hidden[args->primID])
    bounds = placed_bounds(cell.object().get(), cell.instances_.placements[args->primID]);
  RTCBounds& out = *args->bounds_o;
  out.lower_x = bounds.lower.x, out.lower_y = bounds.lower.y, out.lower_z = bounds.lower.z;
  out.upper_x = bounds.upper.x, out.upper_y = bounds.upper.y, out.upper_z = bounds.upper.z;
}

void EmbreeInstanceCell::intersect(const RTCIntersectFunctionNArguments* args) noexcept {
  if (!args->valid[0]) return;
  const auto& cell = *static_cast<const EmbreeInstanceCell*>(args->geometryUserPtr);
  RTCRayHit& outer = *reinterpret_cast<RTCRayHit*>(args->rayhit);
  const InstanceScope instance(args->context, (*cell.instances_.numbers)[args->primID]);
  RTCRayHit query;
  query.ray = carried(outer.ray, cell.instances_.placements[args->primID].world_to_object);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  trace(cell.object().get(), filter_context(args->context), &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return;
  // The first instance wins among surfaces that coincide, whichever cells they are in.
  const bool had_hit = outer.hit.geomID != RTC_INVALID_GEOMETRY_ID;
  if (had_hit && query.ray.tfar == outer.ray.tfar && outer.hit.instID[0] < instance.index()) return;
  outer.ray.tfar = query.ray.tfar;
  outer.hit = query.hit;
}

void EmbreeInstanceCell::occluded(const RTCOccludedFunctionNArguments* args) noexcept {
  if (!args->valid[0]) return;
  const auto& cell = *static_cast<const EmbreeInstanceCell*>(args->geometryUserPtr);
  RTCRay& outer = *reinterpret_cast<RTCRay*>(args->ray);
  const InstanceScope instance(args->context, (*cell.instances_.numbers)[args->primID]);
  RTCRay query = carried(outer, cell.instances_.placements[args->primID].world_to_object);
  trace(cell.object().get(), filter_context(args->context), &query);
  outer.tfar = query.tfar;
}

size_t EmbreeInstanceCell::memory_bytes() const {
  // The share of the hierarchy is an estimate; Embree counts it in the budget.
  constexpr size_t kPerInstance = sizeof(uint32_t) + sizeof(Placement) + 64;
  return sizeof *this + instances_.placements.size() * kPerInstance;
}

std::shared_ptr<const InstanceCell> build_instance_cell(const std::shared_ptr<TraceDevice>& device,
                                                        std::shared_ptr<const ObjectScene> object,
                                                        CellInstances instances,
                                                        const std::function<bool()>& cancelled) {
  auto cell = std::make_shared<EmbreeInstanceCell>(device, std::move(object), std::move(instances));
  return cell->build(cancelled) && !cell->take_error() ? cell : nullptr;
}

}  // namespace alabaster
