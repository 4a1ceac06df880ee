// Preloaded into the program (LD_PRELOAD) by render_time.py: records each ray that a render hands to Embree, and traces
// them all again, bare and in the same order, when the program lets the first of their scenes go. Writes the CPU
// seconds of the fastest of several such replays to $ALABASTER_REPLAY. Rays that pass surfaces by a filter are traced
// without it. Rays that collect all hits by a filter are left out: they belong to the set-up of bodies. Shadow rays
// tell the two filters apart, because no shadow ray collects.
#include <dlfcn.h>
#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif
#include <time.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <mutex>
#include <vector>

namespace {

constexpr int kReplays = 3;

struct RecordedRay {
  float org[3], tfar, dir[3];
  uint32_t scene : 31, occlusion : 1;
  RTCFilterFunctionN filter;
};

struct Recording {
  std::mutex lock;
  std::vector<RecordedRay> rays;
  std::vector<RTCScene> scenes;
  RTCFilterFunctionN passing = nullptr;  // the filter of shadow rays
};
Recording recording;

template <class Function>
Function next_definition(Function, const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}
const auto intersect1 = next_definition(&rtcIntersect1, "rtcIntersect1");
const auto occluded1 = next_definition(&rtcOccluded1, "rtcOccluded1");
const auto release_scene = next_definition(&rtcReleaseScene, "rtcReleaseScene");

void record(RTCScene scene, RTCFilterFunctionN filter, const RTCRay& ray, bool occlusion) {
  const std::lock_guard hold(recording.lock);
  if (occlusion && filter) recording.passing = filter;
  auto& scenes = recording.scenes;
  const auto found = std::find(scenes.begin(), scenes.end(), scene);
  const auto index = static_cast<uint32_t>(found - scenes.begin());
  if (found == scenes.end()) scenes.push_back(scene);
  recording.rays.push_back({{ray.org_x, ray.org_y, ray.org_z},
                            ray.tfar,
                            {ray.dir_x, ray.dir_y, ray.dir_z},
                            index & 0x7fffffffu,
                            occlusion,
                            filter});
}

template <class Function, class Query>
void trace_bare(Function function, RTCScene scene, Query* query) {
#if RTC_VERSION_MAJOR >= 4
  function(scene, query, nullptr);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  function(scene, &context, query);
#endif
}

double thread_cpu_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double replay(size_t* hits) {
  const double begin = thread_cpu_seconds();
  for (const RecordedRay& r : recording.rays) {
    RTCRayHit query;
    query.ray = {r.org[0], r.org[1], r.org[2], 0, r.dir[0], r.dir[1], r.dir[2], 0, r.tfar, ~0u, 0, 0};
    query.hit.geomID = query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    if (r.occlusion) {
      trace_bare(occluded1, recording.scenes[r.scene], &query.ray);
      *hits += query.ray.tfar < 0;
    } else {
      trace_bare(intersect1, recording.scenes[r.scene], &query);
      *hits += query.hit.geomID != RTC_INVALID_GEOMETRY_ID;
    }
  }
  return thread_cpu_seconds() - begin;
}

void replay_all() {
  std::erase_if(recording.rays, [](const RecordedRay& r) { return r.filter && r.filter != recording.passing; });
  double fastest = 0;
  size_t hits = 0;
  for (int i = 0; i < kReplays; ++i) {
    hits = 0;
    const double seconds = replay(&hits);
    fastest = i == 0 ? seconds : std::min(fastest, seconds);
  }
  if (const char* path = std::getenv("ALABASTER_REPLAY"))
    std::ofstream(path) << "{\"rays\": " << recording.rays.size() << ", \"hits\": " << hits
                        << ", \"seconds\": " << fastest << "}\n";
}

}  // namespace

#define EXPORTED __attribute__((visibility("default")))

#if RTC_VERSION_MAJOR >= 4
EXPORTED void rtcIntersect1(RTCScene scene, RTCRayHit* query, RTCIntersectArguments* arguments) {
  record(scene, arguments->filter, query->ray, false);
  intersect1(scene, query, arguments);
}

EXPORTED void rtcOccluded1(RTCScene scene, RTCRay* ray, RTCOccludedArguments* arguments) {
  record(scene, arguments->filter, *ray, true);
  occluded1(scene, ray, arguments);
}
#else
EXPORTED void rtcIntersect1(RTCScene scene, RTCIntersectContext* context, RTCRayHit* query) {
  record(scene, context->filter, query->ray, false);
  intersect1(scene, context, query);
}

EXPORTED void rtcOccluded1(RTCScene scene, RTCIntersectContext* context, RTCRay* ray) {
  record(scene, context->filter, *ray, true);
  occluded1(scene, context, ray);
}
#endif

EXPORTED void rtcReleaseScene(RTCScene scene) {
  {
    const std::lock_guard hold(recording.lock);
    const auto& scenes = recording.scenes;
    if (std::find(scenes.begin(), scenes.end(), scene) != scenes.end()) {
      replay_all();
      recording.rays = {};
      recording.scenes.clear();
    }
  }
  release_scene(scene);
}
