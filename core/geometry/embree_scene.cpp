#include "core/geometry/embree_scene.h"

#include <algorithm>
#include <iterator>

#include "core/geometry/embree_instance_cell.h"
#include "core/geometry/embree_object_scene.h"

namespace alabaster {
namespace {

class EmbreeInstancedScene final : public InstancedScene {
 public:
  EmbreeInstancedScene(std::shared_ptr<TraceDevice> device, const std::vector<InstancePlacement>& instances,
                       const std::vector<InstanceCells>& arrays, const std::function<bool()>& cancelled)
      : scene_(std::move(device), "the hierarchy of instances") {
    if (!scene_.get()) return;
    objects_.resize(instances.size());
    size_ = instances.size();
    for (size_t i = 0; i < instances.size() && !failed_; ++i)
      failed_ = (i % 1024 == 0 && cancelled && cancelled()) || !add(instances[i], static_cast<unsigned>(i));
    arrays_.reserve(arrays.size());
    for (size_t i = 0; i < arrays.size() && !failed_; ++i) failed_ = !add(arrays[i]);
    if (!failed_) failed_ = !commit(scene_.get(), cancelled);
  }
  bool take_error() const { return scene_.take_error() || failed_; }

  bool intersect(const Ray& ray, TriangleHit* hit, const HitFilter* filter) const override {
    if (!growth_.allows(ray) || !intersect_scene(scene_.get(), ray, hit, filter)) return false;
    if (is_at_first_corner(*hit)) [[unlikely]]
      mend(ray, hit);
    return true;
  }

  bool occluded(const Ray& ray, const HitFilter* filter) const override {
    if (!growth_.allows(ray) || !is_traceable(ray)) return false;
    RTCRay query = to_embree(ray);
    FilterContext context = make_context(filter);
    trace(scene_.get(), &context, &query);
    return query.tfar < 0;
  }

  size_t memory_bytes() const override {
    constexpr size_t kBytesPerInstance = 512;    // geometry object, two transforms and its share of the hierarchy
    return objects_.size() * kBytesPerInstance;  // cells count their own
  }

 private:
  struct PlacedCells {
    uint32_t first;  // index of the array's first instance
    InstanceCells array;
    const EmbreeInstanceCell& operator[](size_t i) const {
      return static_cast<const EmbreeInstanceCell&>(*array.cells[i]);  // all come from build_instance_cell
    }
  };

  void mend(const Ray& ray, TriangleHit* hit) const {
    if (hit->instance < objects_.size()) {
      Affine to_world;
      rtcGetGeometryTransform(rtcGetGeometry(scene_.get(), hit->instance), ray.time, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR,
                              &to_world);
      static_cast<const EmbreeObjectScene&>(*objects_[hit->instance]).mend(to_world, ray, hit);
      return;
    }
    const auto after = std::upper_bound(arrays_.begin(), arrays_.end(), hit->instance,
                                        [](uint32_t i, const PlacedCells& a) { return i < a.first; });
    const PlacedCells& cells = *std::prev(after);
    cells[0].object().mend(cells.array.placement(hit->instance - cells.first).object_to_world, ray, hit);
  }

  bool add(const InstancePlacement& placement, unsigned index) {
    const bool moves = !placement.poses.empty();
    const RayGrowth growth = moves ? RayGrowth::of(placement.poses) : RayGrowth::of(placement.object_to_world);
    if (!placement.object || !growth.allows(0, 1)) return true;
    RTCGeometry geometry = rtcNewGeometry(scene_.device(), RTC_GEOMETRY_TYPE_INSTANCE);
    if (!geometry) return false;
    // Every ObjectScene comes from build_object_scene or EditedObject.
    rtcSetGeometryInstancedScene(geometry, static_cast<const EmbreeObjectScene&>(*placement.object).get());
    if (moves) rtcSetGeometryTimeStepCount(geometry, static_cast<unsigned>(placement.poses.size()));
    for (unsigned i = 0; i < placement.poses.size(); ++i) set_transform(geometry, i, placement.poses[i]);
    if (!moves) set_transform(geometry, 0, placement.object_to_world);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene_.get(), geometry, index);
    rtcReleaseGeometry(geometry);
    objects_[index] = placement.object;
    growth_.include(growth);
    return !scene_.take_error();
  }

  // One user geometry, a primitive for each cell.
  bool add(const InstanceCells& array) {
    const auto first = static_cast<uint32_t>(size_);
    size_ += array.size();
    if (array.cells.empty()) return true;
    const PlacedCells& placed = arrays_.emplace_back(PlacedCells{first, array});
    for (size_t i = 0; i < array.cells.size(); ++i) growth_.include(placed[i].growth());
    return attach(
        scene_, {const_cast<PlacedCells*>(&placed), array.cells.size(), &bound_cell, &intersect_cell, &occluded_cell});
  }

  static void bound_cell(const RTCBoundsFunctionArguments* args) noexcept {
    rtcGetSceneBounds((*static_cast<const PlacedCells*>(args->geometryUserPtr))[args->primID].get(), args->bounds_o);
  }
  template <class Query>
  static void trace_cell(const PlacedCells& cells, uint32_t cell, RayContext* context, Query* query) {
    filter_context(context)->first = cells.first;
    trace(cells[cell].get(), filter_context(context), query);
  }
  static void intersect_cell(const RTCIntersectFunctionNArguments* args) noexcept {
    if (!args->valid[0]) return;
    const auto& cells = *static_cast<const PlacedCells*>(args->geometryUserPtr);
    trace_cell(cells, args->primID, args->context, reinterpret_cast<RTCRayHit*>(args->rayhit));
  }
  static void occluded_cell(const RTCOccludedFunctionNArguments* args) noexcept {
    if (!args->valid[0]) return;
    const auto& cells = *static_cast<const PlacedCells*>(args->geometryUserPtr);
    trace_cell(cells, args->primID, args->context, reinterpret_cast<RTCRay*>(args->ray));
  }

  // Embree's columns are the images of the axes and of the origin: the rows of our row-vector matrices.
  static void set_transform(RTCGeometry geometry, unsigned pose, const Affine& m) {
    const float columns[12] = {m.x.x, m.x.y, m.x.z, m.y.x, m.y.y, m.y.z, m.z.x, m.z.y, m.z.z, m.t.x, m.t.y, m.t.z};
    rtcSetGeometryTransform(geometry, pose, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, columns);
  }

  RayGrowth growth_;                                         // of all instances together
  std::vector<std::shared_ptr<const ObjectScene>> objects_;  // by instance, keep-alive; null: never hit
  std::vector<PlacedCells> arrays_;
  size_t size_ = 0;  // instances so far, alone or in arrays
  SceneHandle scene_;
  bool failed_ = false;
};

}  // namespace

std::shared_ptr<TraceDevice> make_trace_device(const DiagnosticSink& sink, std::shared_ptr<MemoryBudget> memory) {
  auto device = std::make_shared<TraceDevice>(sink, std::move(memory));
  return device->get() ? device : nullptr;
}

const std::shared_ptr<MemoryBudget>& memory_of(const TraceDevice& device) {
  return device.memory();
}

std::shared_ptr<const InstancedScene> build_instanced_scene(const std::shared_ptr<TraceDevice>& device,
                                                            const std::vector<InstancePlacement>& instances,
                                                            const std::function<bool()>& cancelled,
                                                            const std::vector<InstanceCells>& arrays) {
  auto scene = std::make_shared<EmbreeInstancedScene>(device, instances, arrays, cancelled);
  return scene->take_error() ? nullptr : scene;
}

}  // namespace alabaster
