#include "core/geometry/embree_object_scene.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <new>

namespace alabaster {
namespace {

// Embree takes a hit for one of the first corner where twice the triangle's area is below 1e-18 (its min_rcp_input):
// scenes a nanometre wide in metres. The coordinates in its place; `to_world` carries the mesh to the ray's space.
void mend_corner(RTCGeometry mesh, const Corners& c, const Affine& to_world, const Ray& ray, TriangleHit* hit) {
  const auto* points = static_cast<const Vec3f*>(rtcGetGeometryBufferData(mesh, RTC_BUFFER_TYPE_VERTEX, 0));
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

// Embree hands the context back to the filter, so it must begin with Embree's.
struct CollectContext {
  RayContext embree;
  std::pmr::vector<TriangleHit>* hits;
  bool out_of_memory;
};

// Keeps the hit and rejects it, so that the traversal goes on to the next. No exception may cross Embree.
void collect_hit(const RTCFilterFunctionNArguments* args) noexcept {
  auto& context = *reinterpret_cast<CollectContext*>(args->context);
  args->valid[0] = 0;
  try {
    TriangleHit& hit = context.hits->emplace_back();
    hit = {RTCRayN_tfar(args->ray, args->N, 0),
           RTCHitN_u(args->hit, args->N, 0),
           RTCHitN_v(args->hit, args->N, 0),
           RTCHitN_primID(args->hit, args->N, 0),
           0,
           RTCRayN_time(args->ray, args->N, 0)};
    name_triangle(RTCHitN_geomID(args->hit, args->N, 0), &hit);
  } catch (...) {
    context.out_of_memory = true;
  }
}

void intersect_all_in_scene(RTCScene scene, const Ray& ray, std::pmr::vector<TriangleHit>* hits) {
  hits->clear();
  if (!is_traceable(ray)) return;
  RTCRayHit query = to_query(ray);
  CollectContext context{{}, hits, false};
  init(&context.embree);
  trace(scene, &context.embree, &collect_hit, &query);
  if (context.out_of_memory) throw std::bad_alloc();
  std::sort(hits->begin(), hits->end(), [](const TriangleHit& a, const TriangleHit& b) {
    return a.t < b.t || (a.t == b.t && a.triangle < b.triangle);
  });
}

struct Slot {
  RTCBufferType type;
  unsigned slot;
  RTCFormat format;
};

bool fill(RTCGeometry geometry, const Slot& to, const void* data, size_t stride, size_t count) {
  void* buffer = rtcSetNewGeometryBuffer(geometry, to.type, to.slot, to.format, stride, count);
  if (!buffer) return false;
  std::memcpy(buffer, data, count * stride);
  return true;
}

bool fill_quads(RTCGeometry geometry, const std::vector<Corners>& triangles) {
  const size_t quads = triangles.size() / 2;
  auto* const buffer = static_cast<QuadCorners*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4, sizeof(QuadCorners), quads));
  for (size_t i = 0; buffer && i < quads; ++i) buffer[i] = quad_of(triangles[2 * i], triangles[2 * i + 1]);
  return buffer != nullptr;
}

}  // namespace

bool EmbreeObjectScene::attach(const Mesh& mesh) {
  RTCGeometry geometry = rtcNewGeometry(scene_.device(), quads_ ? RTC_GEOMETRY_TYPE_QUAD : RTC_GEOMETRY_TYPE_TRIANGLE);
  if (!geometry) return false;
  const bool refits = use_ == Use::refitted && (kRefitsQuads || !quads_);  // else it is built again
  if (refits) rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_REFIT);
  rtcSetGeometryTimeStepCount(geometry, static_cast<unsigned>(poses_));
  bool filled = quads_ ? fill_quads(geometry, mesh.triangles)
                       : fill(geometry, {RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3}, mesh.triangles.data(),
                              sizeof(Corners), triangles_);
  for (unsigned i = 0; i < poses_ && filled; ++i)
    filled = fill(geometry, {RTC_BUFFER_TYPE_VERTEX, i, RTC_FORMAT_FLOAT3}, mesh.points_of_pose(i).data(),
                  sizeof(Vec3f), points_);
  if (filled) {
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene_.get(), geometry, quads_ ? kQuads : kTriangles);
  }
  rtcReleaseGeometry(geometry);
  return !scene_.take_error() && filled;
}

RTCGeometry EmbreeObjectScene::geometry() const {
  return rtcGetGeometry(scene_.get(), quads_ ? kQuads : kTriangles);
}

const void* EmbreeObjectScene::indices() const {
  return rtcGetGeometryBufferData(geometry(), RTC_BUFFER_TYPE_INDEX, 0);
}

Corners EmbreeObjectScene::corners(const void* indices, size_t triangle) const {
  if (!quads_) return static_cast<const Corners*>(indices)[triangle];
  return triangle_of(static_cast<const QuadCorners*>(indices)[triangle / 2], triangle % 2 != 0);
}

bool EmbreeObjectScene::has_triangles_of(const Mesh& mesh) const {
  if (poses_ != 1 || mesh.deforms() || mesh.points.size() != points_ || mesh.triangles.size() != triangles_)
    return false;
  if (triangles_ == 0) return false;
  const void* const own = indices();
  for (size_t i = 0; i < triangles_; ++i)
    if (corners(own, i) != mesh.triangles[i]) return false;
  return true;
}

bool EmbreeObjectScene::replace_points(const Mesh& mesh) {
  scene_.forget_error();  // an earlier error is not ours
  void* const points = rtcGetGeometryBufferData(geometry(), RTC_BUFFER_TYPE_VERTEX, 0);
  if (!points) return false;
  std::memcpy(points, mesh.points.data(), points_ * sizeof(Vec3f));
  rtcUpdateGeometryBuffer(geometry(), RTC_BUFFER_TYPE_VERTEX, 0);
  rtcCommitGeometry(geometry());
  return true;
}

bool EmbreeObjectScene::intersect(const Ray& ray, TriangleHit* hit) const {
  if (!intersect_scene(scene_.get(), ray, hit)) return false;
  if (is_at_first_corner(*hit)) [[unlikely]]
    mend(Affine(), ray, hit);
  return true;
}

void EmbreeObjectScene::mend(const Affine& to_world, const Ray& ray, TriangleHit* hit) const {
  if (poses_ == 1) mend_corner(geometry(), corners(indices(), hit->triangle), to_world, ray, hit);
}

void EmbreeObjectScene::intersect_all(const Ray& ray, std::pmr::vector<TriangleHit>* hits) const {
  intersect_all_in_scene(scene_.get(), ray, hits);
  for (TriangleHit& hit : *hits)
    if (is_at_first_corner(hit)) [[unlikely]]
      mend(Affine(), ray, &hit);
}

std::shared_ptr<const ObjectScene> build_object_scene(const std::shared_ptr<TraceDevice>& device, const Mesh& mesh,
                                                      const std::function<bool()>& cancelled) {
  auto object = std::make_shared<EmbreeObjectScene>(device, mesh);
  const bool attached = object->get() && (mesh.triangles.empty() || object->attach(mesh));
  if (attached && !commit(object->get(), cancelled)) return nullptr;
  return object->take_error() || !attached ? nullptr : object;
}

}  // namespace alabaster
