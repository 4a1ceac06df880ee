// Embree as the files of this room share it: scenes, their builds and queries. Internal to this room.
#pragma once

#include <tbb/task_arena.h>

#include <atomic>
#include <functional>
#include <memory>
#include <utility>

#include "core/geometry/embree_scene.h"
#include "core/geometry/trace_device.h"

namespace alabaster {

// Where Embree 3 (Debian 12) and Embree 4 (Debian 13) differ. A query's filter is a member of the context in Embree 3,
// and an argument of the query in Embree 4.
#if RTC_VERSION_MAJOR >= 4
using RayContext = RTCRayQueryContext;
inline constexpr int kFilterFlag = RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS;
// A refit leaves the fourth corner of some quads at its old place (QuadMv::update constructs v3 from itself).
inline constexpr bool kRefitsQuads = false;
inline void init(RayContext* context) {
  rtcInitRayQueryContext(context);
}
template <class Arguments>
Arguments* with(RayContext* context, RTCFilterFunctionN filter, Arguments* arguments) {
  arguments->context = context;
  if (!filter) return arguments;
  arguments->filter = filter;
  arguments->flags = RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER;
  return arguments;
}
inline void trace(RTCScene scene, RayContext* context, RTCFilterFunctionN filter, RTCRayHit* query) {
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  rtcIntersect1(scene, query, with(context, filter, &arguments));
}
inline void trace(RTCScene scene, RayContext* context, RTCFilterFunctionN filter, RTCRay* query) {
  RTCOccludedArguments arguments;
  rtcInitOccludedArguments(&arguments);
  rtcOccluded1(scene, query, with(context, filter, &arguments));
}
#else
using RayContext = RTCIntersectContext;
inline constexpr int kFilterFlag = RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION;
inline constexpr bool kRefitsQuads = true;
inline void init(RayContext* context) {
  rtcInitIntersectContext(context);
}
inline void trace(RTCScene scene, RayContext* context, RTCFilterFunctionN filter, RTCRayHit* query) {
  context->filter = filter;
  rtcIntersect1(scene, context, query);
}
inline void trace(RTCScene scene, RayContext* context, RTCFilterFunctionN filter, RTCRay* query) {
  context->filter = filter;
  rtcOccluded1(scene, context, query);
}
#endif

// Owns an Embree scene and, through it, the device that it lives on.
class SceneHandle {
 public:
  // A dynamic scene has a hierarchy for each mesh, below one that is built in no time, and keeps what it takes to fit
  // it to other points.
  // `what` it is, in refusals of memory: a literal.
  SceneHandle(std::shared_ptr<TraceDevice> device, const char* what, bool dynamic = false)
      : device_(std::move(device)), what_(what) {
    device_->forget_error();  // an earlier error is not ours
    scene_ = rtcNewScene(device_->get());
    if (!scene_) {
      take_error();
      return;
    }
    // ROBUST: neighbouring triangles leave no gap. COMPACT would halve the peak memory of the build, but its indexed
    // triangles trace a quarter slower. The filter function collects all hits of a ray; single rays trace as fast with
    // the flag as without.
    const int flags = RTC_SCENE_FLAG_ROBUST | kFilterFlag;
    rtcSetSceneFlags(scene_, static_cast<RTCSceneFlags>(dynamic ? flags | RTC_SCENE_FLAG_DYNAMIC : flags));
    rtcSetSceneBuildQuality(scene_, dynamic ? RTC_BUILD_QUALITY_LOW : RTC_BUILD_QUALITY_MEDIUM);
  }
  ~SceneHandle() {
    if (scene_) rtcReleaseScene(scene_);
  }
  SceneHandle(const SceneHandle&) = delete;
  SceneHandle& operator=(const SceneHandle&) = delete;

  RTCScene get() const { return scene_; }
  RTCDevice device() const { return device_->get(); }
  // True: Embree refused something (reported). Throws where memory ran out.
  bool take_error() const { return device_->take_error(what_) || !scene_; }
  void forget_error() const { device_->forget_error(); }

 private:
  std::shared_ptr<TraceDevice> device_;
  const char* what_;
  RTCScene scene_ = nullptr;
};

/// User geometry in a scene.
struct UserGeometry {
  void* data;
  size_t count;
  RTCBoundsFunction bounds;
  RTCIntersectFunctionN intersect;
  RTCOccludedFunctionN occluded;
};
// False: Embree refuses. Throws where memory runs out.
inline bool attach(const SceneHandle& scene, const UserGeometry& from) {
  RTCGeometry geometry = rtcNewGeometry(scene.device(), RTC_GEOMETRY_TYPE_USER);
  if (!geometry) {
    scene.take_error();
    return false;
  }
  rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(from.count));
  rtcSetGeometryUserData(geometry, from.data);
  rtcSetGeometryBoundsFunction(geometry, from.bounds, nullptr);
  rtcSetGeometryIntersectFunction(geometry, from.intersect);
  rtcSetGeometryOccludedFunction(geometry, from.occluded);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene.get(), geometry);
  rtcReleaseGeometry(geometry);
  return !scene.take_error();
}

inline RTCRay to_embree(const Ray& ray) {
  const Vec3f &o = ray.org, &d = ray.dir;
  // Members: org, tnear, dir, time, tfar, mask, id, flags.
  return {o.x, o.y, o.z, 0, d.x, d.y, d.z, ray.time, ray.tmax, ~0u, 0, 0};
}

// Without a hit so far.
inline RTCRayHit to_query(const Ray& ray) {
  RTCRayHit query;
  query.ray = to_embree(ray);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  return query;
}

// A mesh is one geometry of its scene: of triangles, or of quads where all its triangles are in pairs
// (triangle_pairs.h).
inline constexpr unsigned kTriangles = 0, kQuads = 1;

// The triangle of a hit, where Embree's answer names a quad. Its second triangle has the coordinates 1 - u and 1 - v.
// Hits on the common edge are of the first.
inline void name_triangle(unsigned geometry, TriangleHit* hit) {
  if (geometry != kQuads) return;
  const bool second = hit->u + hit->v > 1;
  hit->triangle = 2 * hit->triangle + (second ? 1 : 0);
  if (second) hit->u = 1 - hit->u, hit->v = 1 - hit->v;
}

// Embree hands the context back to the filter, so it must begin with Embree's.
struct FilterContext {
  RayContext embree;
  const HitFilter* filter;
  uint32_t first = 0;  // index of the first instance of the array that the ray is in
};

inline void ask_filter(const RTCFilterFunctionNArguments* args) noexcept {
  const auto& context = *reinterpret_cast<const FilterContext*>(args->context);
  TriangleHit hit{
      RTCRayN_tfar(args->ray, args->N, 0),
      RTCHitN_u(args->hit, args->N, 0),
      RTCHitN_v(args->hit, args->N, 0),
      RTCHitN_primID(args->hit, args->N, 0),
      RTCHitN_instID(args->hit, args->N, 0, 0),
      RTCRayN_time(args->ray, args->N, 0),
      {RTCHitN_Ng_x(args->hit, args->N, 0), RTCHitN_Ng_y(args->hit, args->N, 0), RTCHitN_Ng_z(args->hit, args->N, 0)}};
  name_triangle(RTCHitN_geomID(args->hit, args->N, 0), &hit);
  if (!context.filter->stops(hit)) args->valid[0] = 0;
}

inline FilterContext make_context(const HitFilter* filter) {
  FilterContext context{{}, filter};
  init(&context.embree);
  return context;
}

// Callbacks that trace on do it by this, too: a query inherits no filter.
template <class Query>
void trace(RTCScene scene, FilterContext* context, Query* query) {
  trace(scene, &context->embree, context->filter ? &ask_filter : nullptr, query);
}

inline FilterContext* filter_context(RayContext* context) {
  return reinterpret_cast<FilterContext*>(context);
}

inline bool intersect_scene(RTCScene scene, const Ray& ray, TriangleHit* hit, const HitFilter* filter = nullptr) {
  if (!is_traceable(ray)) return false;
  RTCRayHit query = to_query(ray);
  FilterContext context = make_context(filter);
  trace(scene, &context, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
  hit->t = query.ray.tfar;
  hit->u = query.hit.u;
  hit->v = query.hit.v;
  hit->triangle = query.hit.primID;
  name_triangle(query.hit.geomID, hit);
  hit->instance = query.hit.instID[0] == RTC_INVALID_GEOMETRY_ID ? 0 : query.hit.instID[0];
  hit->time = ray.time;
  hit->normal = {query.hit.Ng_x, query.hit.Ng_y, query.hit.Ng_z};
  return true;
}

inline bool is_at_first_corner(const TriangleHit& hit) {
  return hit.u == 0 && hit.v == 0;
}

struct BuildMonitor {
  const std::function<bool()>& cancelled;
  std::atomic<bool> stopped{false};
};

// Embree asks from its worker threads, possibly several at once.
inline bool continue_build(void* data, double) {
  auto& monitor = *static_cast<BuildMonitor*>(data);
  if (monitor.cancelled()) monitor.stopped = true;
  return !monitor.stopped;
}

// Waits in the caller's task arena; rtcJoinCommitScene would move the build to an arena of Embree's own. False: it was
// cancelled.
//
// A scene keeps a task group. Inside of a parallel loop the loop's context would become that group's parent, and later
// cancellations in TBB follow pointers to parents, long after the loop. In an arena's own context a group has none.
inline bool commit(RTCScene scene, const std::function<bool()>& cancelled) {
  BuildMonitor monitor{cancelled};
  if (cancelled) {
    if (cancelled()) return false;  // small builds never ask
    rtcSetSceneProgressMonitorFunction(scene, &continue_build, &monitor);
  }
  tbb::task_arena(tbb::task_arena::attach()).execute([scene] { rtcCommitScene(scene); });
  rtcSetSceneProgressMonitorFunction(scene, nullptr, nullptr);
  return !monitor.stopped;
}

}  // namespace alabaster
