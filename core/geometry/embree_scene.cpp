#include "core/geometry/embree_scene.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <new>
#include <string>
#include <utility>

#include "core/geometry/trace_device.h"

namespace alabaster {

namespace {

// Owns an Embree scene and, through it, the device that it lives on.
class SceneHandle {
 public:
  explicit SceneHandle(std::shared_ptr<TraceDevice> device) : device_(std::move(device)) {
    device_->take_error();  // an earlier error is not ours
    scene_ = rtcNewScene(device_->get());
    if (!scene_) return;
    // ROBUST: neighbouring triangles leave no gap. COMPACT would halve the peak memory of the build, but its indexed
    // triangles trace a quarter slower. The filter function collects all hits of a ray; single rays trace as fast with
    // the flag as without.
    rtcSetSceneFlags(scene_,
                     static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION));
    rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_MEDIUM);
  }
  ~SceneHandle() {
    if (scene_) rtcReleaseScene(scene_);
  }
  SceneHandle(const SceneHandle&) = delete;
  SceneHandle& operator=(const SceneHandle&) = delete;

  RTCScene get() const { return scene_; }
  RTCDevice device() const { return device_->get(); }
  bool take_error() const { return !scene_ || device_->take_error(); }

 private:
  std::shared_ptr<TraceDevice> device_;
  RTCScene scene_ = nullptr;
};

RTCRay to_embree(const Ray& ray) {
  const Vec3f &o = ray.org, &d = ray.dir;
  // Members: org, tnear, dir, time, tfar, mask, id, flags.
  return {o.x, o.y, o.z, 0, d.x, d.y, d.z, ray.time, ray.tmax, ~0u, 0, 0};
}

// Without a hit so far.
RTCRayHit to_query(const Ray& ray) {
  RTCRayHit query;
  query.ray = to_embree(ray);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  return query;
}

// Bounds of a placement's map into object space: coordinates there stay below stretch * coordinates + shift.
struct Growth {
  float stretch = 0, shift = 0;

  // As Embree inverts, adjoint over determinant, all in float: an under- or overflow here is one there.
  static Growth of(const Affine& m) {
    const Vec3f columns[] = {cross(m.y, m.z), cross(m.z, m.x), cross(m.x, m.y)};
    const float determinant = dot(m.x, columns[0]), size = std::abs(determinant);
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    if (!(size > 1e-37f && size < 1e37f)) return {kInfinity, kInfinity};
    Growth growth;
    for (const Vec3f& column : columns) {
      const Vec3f c = column * (1 / determinant);
      const float stretch = std::abs(c.x) + std::abs(c.y) + std::abs(c.z), shift = std::abs(dot(m.t, c));
      if (!std::isfinite(stretch) || !std::isfinite(shift)) return {kInfinity, kInfinity};
      growth.include({stretch, shift});
    }
    return growth;
  }
  void include(const Growth& other) {
    stretch = std::max(stretch, other.stretch);
    shift = std::max(shift, other.shift);
  }
  // Between two poses the inverse is at most as large as the least stretch allows.
  static Growth of(const std::vector<Affine>& poses) {
    const float least = least_stretch_over(poses);
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    const float stretch = least > 0 ? 2 / least : kInfinity;
    Growth growth{stretch, 0};
    for (const Affine& pose : poses) {
      growth.include(of(pose));
      growth.shift = std::max(growth.shift, 2 * stretch * max_abs_component(pose.t));
    }
    return std::isfinite(growth.shift) ? growth : Growth{kInfinity, kInfinity};
  }
  bool allows(float origin, float direction) const {
    return origin * stretch + shift < kTraceLimit && direction * stretch < kTraceLimit;
  }
  bool allows(const Ray& ray) const { return allows(max_abs_component(ray.org), max_abs_component(ray.dir)); }
};

// Embree hands the context back to the filter, so it must begin with Embree's.
struct FilterContext {
  RTCIntersectContext embree;
  const HitFilter* filter;
};

void ask_filter(const RTCFilterFunctionNArguments* args) noexcept {
  const auto& context = *reinterpret_cast<const FilterContext*>(args->context);
  const TriangleHit hit{RTCRayN_tfar(args->ray, args->N, 0),      RTCHitN_u(args->hit, args->N, 0),
                        RTCHitN_v(args->hit, args->N, 0),         RTCHitN_primID(args->hit, args->N, 0),
                        RTCHitN_instID(args->hit, args->N, 0, 0), RTCRayN_time(args->ray, args->N, 0)};
  if (!context.filter->stops(hit)) args->valid[0] = 0;
}

FilterContext make_context(const HitFilter* filter) {
  FilterContext context{{}, filter};
  rtcInitIntersectContext(&context.embree);
  if (filter) context.embree.filter = &ask_filter;
  return context;
}

bool intersect_scene(RTCScene scene, const Ray& ray, TriangleHit* hit, const HitFilter* filter = nullptr) {
  if (!is_traceable(ray)) return false;
  RTCRayHit query = to_query(ray);
  FilterContext context = make_context(filter);
  rtcIntersect1(scene, &context.embree, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
  hit->t = query.ray.tfar;
  hit->u = query.hit.u;
  hit->v = query.hit.v;
  hit->triangle = query.hit.primID;
  hit->instance = query.hit.instID[0] == RTC_INVALID_GEOMETRY_ID ? 0 : query.hit.instID[0];
  hit->time = ray.time;
  return true;
}

// Embree takes a hit for one of the first corner where twice the triangle's area is below 1e-18 (its min_rcp_input):
// scenes a nanometre wide in metres. The coordinates in its place; `to_world` carries the mesh to the ray's space.
void mend_corner(RTCScene mesh, const Affine& to_world, const Ray& ray, TriangleHit* hit) {
  const RTCGeometry geometry = rtcGetGeometry(mesh, 0);
  const auto* points = static_cast<const Vec3f*>(rtcGetGeometryBufferData(geometry, RTC_BUFFER_TYPE_VERTEX, 0));
  const auto* triangles = static_cast<const Corners*>(rtcGetGeometryBufferData(geometry, RTC_BUFFER_TYPE_INDEX, 0));
  const Corners& c = triangles[hit->triangle];
  const Vec3d e1 = Vec3d(points[c[1]]) - Vec3d(points[c[0]]), e2 = Vec3d(points[c[2]]) - Vec3d(points[c[0]]);
  if (length(cross(e1, e2)) > 1e-17) return;
  // Moeller and Trumbore 1997, in double.
  const auto carried = [&](const Vec3d& v) {
    return Vec3d(to_world.x) * v.x + Vec3d(to_world.y) * v.y + Vec3d(to_world.z) * v.z;
  };
  const Vec3d a = carried(e1), b = carried(e2), d(ray.dir);
  const Vec3d s = Vec3d(ray.org) - Vec3d(to_world.t) - carried(Vec3d(points[c[0]])), p = cross(d, b);
  const double determinant = dot(a, p);
  if (determinant == 0) return;
  const double u = std::clamp(dot(s, p) / determinant, 0.0, 1.0);
  hit->u = static_cast<float>(u);
  hit->v = static_cast<float>(std::clamp(dot(d, cross(s, a)) / determinant, 0.0, 1 - u));
}

bool is_at_first_corner(const TriangleHit& hit) {
  return hit.u == 0 && hit.v == 0;
}

// Embree hands the context back to the filter, so it must begin with Embree's.
struct CollectContext {
  RTCIntersectContext embree;
  std::pmr::vector<TriangleHit>* hits;
  bool out_of_memory;
};

// Keeps the hit and rejects it, so that the traversal goes on to the next. No exception may cross Embree.
void collect_hit(const RTCFilterFunctionNArguments* args) noexcept {
  auto& context = *reinterpret_cast<CollectContext*>(args->context);
  args->valid[0] = 0;
  try {
    context.hits->push_back({RTCRayN_tfar(args->ray, args->N, 0), RTCHitN_u(args->hit, args->N, 0),
                             RTCHitN_v(args->hit, args->N, 0), RTCHitN_primID(args->hit, args->N, 0), 0,
                             RTCRayN_time(args->ray, args->N, 0)});
  } catch (...) {
    context.out_of_memory = true;
  }
}

void intersect_all_in_scene(RTCScene scene, const Ray& ray, std::pmr::vector<TriangleHit>* hits) {
  hits->clear();
  if (!is_traceable(ray)) return;
  RTCRayHit query = to_query(ray);
  CollectContext context{{}, hits, false};
  rtcInitIntersectContext(&context.embree);
  context.embree.filter = &collect_hit;
  rtcIntersect1(scene, &context.embree, &query);
  if (context.out_of_memory) throw std::bad_alloc();
  std::sort(hits->begin(), hits->end(), [](const TriangleHit& a, const TriangleHit& b) {
    return a.t < b.t || (a.t == b.t && a.triangle < b.triangle);
  });
}

class EmbreeObjectScene final : public ObjectScene {
 public:
  EmbreeObjectScene(std::shared_ptr<TraceDevice> device, const Mesh& mesh)
      : scene_(std::move(device)),
        points_(mesh.points.size()),
        triangles_(mesh.triangles.size()),
        poses_(1 + mesh.later_poses.size()) {}

  /// Copies the mesh into buffers that Embree allocates (and pads: it reads 16 bytes at each 12-byte vertex).
  bool attach(const Mesh& mesh) {
    RTCGeometry geometry = rtcNewGeometry(scene_.device(), RTC_GEOMETRY_TYPE_TRIANGLE);
    if (!geometry) return false;
    rtcSetGeometryTimeStepCount(geometry, static_cast<unsigned>(poses_));
    bool filled = fill(geometry, {RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3}, mesh.triangles.data(),
                       3 * sizeof(uint32_t), triangles_);
    for (unsigned i = 0; i < poses_ && filled; ++i)
      filled = fill(geometry, {RTC_BUFFER_TYPE_VERTEX, i, RTC_FORMAT_FLOAT3}, mesh.points_of_pose(i).data(),
                    sizeof(Vec3f), points_);
    if (filled) {
      rtcCommitGeometry(geometry);
      rtcAttachGeometryByID(scene_.get(), geometry, 0);
    }
    rtcReleaseGeometry(geometry);
    return filled;
  }

  bool intersect(const Ray& ray, TriangleHit* hit) const override {
    if (!intersect_scene(scene_.get(), ray, hit)) return false;
    if (is_at_first_corner(*hit)) [[unlikely]]
      mend(Affine(), ray, hit);
    return true;
  }
  /// A mesh that deforms is left as it is.
  void mend(const Affine& to_world, const Ray& ray, TriangleHit* hit) const {
    if (poses_ == 1) mend_corner(scene_.get(), to_world, ray, hit);
  }
  void intersect_all(const Ray& ray, std::pmr::vector<TriangleHit>* hits) const override {
    const size_t before = hits->size();
    intersect_all_in_scene(scene_.get(), ray, hits);
    for (size_t i = before; i < hits->size(); ++i)
      if (is_at_first_corner((*hits)[i])) [[unlikely]]
        mend(Affine(), ray, &(*hits)[i]);
  }

  size_t memory_bytes() const override {
    // The buffers are known; the hierarchy takes about 66 bytes a triangle (Embree 3.13 does not tell per scene).
    const size_t hierarchy_per_triangle = poses_ > 1 ? 200 : 66;
    return poses_ * points_ * sizeof(Vec3f) + triangles_ * (3 * sizeof(uint32_t) + hierarchy_per_triangle);
  }
  RTCScene get() const { return scene_.get(); }
  bool take_error() const { return scene_.take_error(); }

 private:
  struct Slot {
    RTCBufferType type;
    unsigned slot;
    RTCFormat format;
  };
  static bool fill(RTCGeometry geometry, const Slot& to, const void* data, size_t stride, size_t count) {
    void* buffer = rtcSetNewGeometryBuffer(geometry, to.type, to.slot, to.format, stride, count);
    if (!buffer) return false;
    std::memcpy(buffer, data, count * stride);
    return true;
  }

  SceneHandle scene_;
  size_t points_, triangles_, poses_;
};

struct BuildMonitor {
  const std::function<bool()>& cancelled;
  std::atomic<bool> stopped{false};
};

// Embree asks from its worker threads, possibly several at once.
bool continue_build(void* data, double) {
  auto& monitor = *static_cast<BuildMonitor*>(data);
  if (monitor.cancelled()) monitor.stopped = true;
  return !monitor.stopped;
}

// Waits in the caller's task arena; rtcJoinCommitScene would move the build to an arena of Embree's own. False: it was
// cancelled.
//
// A scene keeps a task group. Inside of a parallel loop the loop's context would become that group's parent, and later
// cancellations in TBB follow pointers to parents, long after the loop. In an arena's own context a group has none.
bool commit(RTCScene scene, const std::function<bool()>& cancelled) {
  BuildMonitor monitor{cancelled};
  if (cancelled) {
    if (cancelled()) return false;  // small builds never ask
    rtcSetSceneProgressMonitorFunction(scene, &continue_build, &monitor);
  }
  tbb::task_arena(tbb::task_arena::attach()).execute([scene] { rtcCommitScene(scene); });
  rtcSetSceneProgressMonitorFunction(scene, nullptr, nullptr);
  return !monitor.stopped;
}

class EmbreeInstancedScene final : public InstancedScene {
 public:
  EmbreeInstancedScene(std::shared_ptr<TraceDevice> device, const std::vector<InstancePlacement>& instances,
                       const std::function<bool()>& cancelled)
      : scene_(std::move(device)) {
    if (!scene_.get()) return;
    objects_.resize(instances.size());
    for (size_t i = 0; i < instances.size() && !failed_; ++i)
      failed_ = (i % 1024 == 0 && cancelled && cancelled()) || !add(instances[i], static_cast<unsigned>(i));
    if (!failed_) failed_ = !commit(scene_.get(), cancelled);
  }
  bool take_error() const { return scene_.take_error() || failed_; }

  bool intersect(const Ray& ray, TriangleHit* hit, const HitFilter* filter) const override {
    if (!growth_.allows(ray) || !intersect_scene(scene_.get(), ray, hit, filter)) return false;
    if (is_at_first_corner(*hit)) [[unlikely]] {
      Affine to_world;
      rtcGetGeometryTransform(rtcGetGeometry(scene_.get(), hit->instance), ray.time, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR,
                              &to_world);
      static_cast<const EmbreeObjectScene&>(*objects_[hit->instance]).mend(to_world, ray, hit);
    }
    return true;
  }

  bool occluded(const Ray& ray, const HitFilter* filter) const override {
    if (!growth_.allows(ray) || !is_traceable(ray)) return false;
    RTCRay query = to_embree(ray);
    FilterContext context = make_context(filter);
    rtcOccluded1(scene_.get(), &context.embree, &query);
    return query.tfar < 0;
  }

  size_t memory_bytes() const override {
    constexpr size_t kBytesPerInstance = 512;  // geometry object, two transforms and its share of the hierarchy
    return objects_.size() * kBytesPerInstance;
  }

 private:
  bool add(const InstancePlacement& placement, unsigned index) {
    const bool moves = !placement.poses.empty();
    const Growth growth = moves ? Growth::of(placement.poses) : Growth::of(placement.object_to_world);
    if (!placement.object || !growth.allows(0, 1)) return true;
    RTCGeometry geometry = rtcNewGeometry(scene_.device(), RTC_GEOMETRY_TYPE_INSTANCE);
    if (!geometry) return false;
    // Every ObjectScene comes from build_object_scene.
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

  // Embree's columns are the images of the axes and of the origin: the rows of our row-vector matrices.
  static void set_transform(RTCGeometry geometry, unsigned pose, const Affine& m) {
    const float columns[12] = {m.x.x, m.x.y, m.x.z, m.y.x, m.y.y, m.y.z, m.z.x, m.z.y, m.z.z, m.t.x, m.t.y, m.t.z};
    rtcSetGeometryTransform(geometry, pose, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, columns);
  }

  Growth growth_;                                            // of all instances together
  std::vector<std::shared_ptr<const ObjectScene>> objects_;  // by instance, keep-alive; null: never hit
  SceneHandle scene_;
  bool failed_ = false;
};

}  // namespace

bool is_traceable(const Affine& object_to_world, float distance) {
  return Growth::of(object_to_world).allows(distance, 1);
}

bool is_traceable(const std::vector<Affine>& poses, float distance) {
  return Growth::of(poses).allows(distance, 1);
}

std::shared_ptr<TraceDevice> make_trace_device(const DiagnosticSink& sink, std::shared_ptr<MemoryBudget> memory) {
  auto device = std::make_shared<TraceDevice>(sink, std::move(memory));
  return device->get() ? device : nullptr;
}

const std::shared_ptr<MemoryBudget>& memory_of(const TraceDevice& device) {
  return device.memory();
}

std::shared_ptr<const ObjectScene> build_object_scene(const std::shared_ptr<TraceDevice>& device, const Mesh& mesh,
                                                      const std::function<bool()>& cancelled) {
  auto object = std::make_shared<EmbreeObjectScene>(device, mesh);
  if (!object->get()) return nullptr;
  if (!mesh.triangles.empty() && !object->attach(mesh)) return nullptr;
  if (!commit(object->get(), cancelled) || object->take_error()) return nullptr;
  return object;
}

std::shared_ptr<const InstancedScene> build_instanced_scene(const std::shared_ptr<TraceDevice>& device,
                                                            const std::vector<InstancePlacement>& instances,
                                                            const std::function<bool()>& cancelled) {
  auto scene = std::make_shared<EmbreeInstancedScene>(device, instances, cancelled);
  return scene->take_error() ? nullptr : scene;
}

}  // namespace alabaster
