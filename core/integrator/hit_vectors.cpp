#include "core/integrator/hit_vectors.h"

namespace alabaster {
namespace {

Vec3f point_on(const std::array<Vec3f, 3>& corners, const TriangleHit& hit) {
  return corners[0] * (1 - hit.u - hit.v) + corners[1] * hit.u + corners[2] * hit.v;
}

// The point of the surface that was hit, in render space, at an end of the time that AOV motion shows. What has no ends
// stands still.
Vec3f point_at_end(const Vertex& v, size_t end) {
  const InstanceEnds* const ends = v.instance->ends.get();
  if (!ends) return v.hit.p;
  const Mesh& mesh = v.instance->prototype->mesh;
  std::array<Vec3f, 3> corners = mesh.corners_at(v.triangle.triangle, v.triangle.time);
  if (ends->mesh)
    for (size_t i = 0; i < 3; ++i) corners[i] = ends->mesh->points[end][mesh.triangles[v.triangle.triangle][i]];
  return ends->object_to_world[end].point(point_on(corners, v.triangle));
}

// The same at another time.
Vec3f point_at(const Vertex& v, float time) {
  const Vec3f p = point_on(v.instance->prototype->mesh.corners_at(v.triangle.triangle, time), v.triangle);
  TriangleHit then = v.triangle;
  then.time = time;
  std::optional<Placement> moved;
  return v.instance->at(then, &moved).object_to_world.point(p);
}

// x to the right and y up, as rows of buffers go. Zero where the point is behind the camera at either time.
Vec3f motion_of(const HitVectorRequest& request, const Vertex& v) {
  const auto from = request.opens.project(request.at_ends ? point_at_end(v, 0) : point_at(v, request.open_time));
  const auto to = request.closes.project(request.at_ends ? point_at_end(v, 1) : point_at(v, request.close_time));
  return from && to ? Vec3f(to->x - from->x, from->y - to->y, 0) : Vec3f(0, 0, 0);
}

Vec3f uv_of(const Vertex& v) {
  static const UvSetName kUsual("st");
  const Vec2f uv =
      v.instance->prototype->mesh.uv_set(kUsual) ? v.instance->primvars_at(v.triangle, v.hit.uv).uv(kUsual) : v.hit.uv;
  return {uv.x, uv.y, 0};
}

Vec3f primvar_at(const Vertex& v, const UvSetName& name) {
  Vec4f numbers;
  v.instance->primvars_at(v.triangle, v.hit.uv).read(name, &numbers);
  return {numbers.x, numbers.y, numbers.z};
}

}  // namespace

void record_hit_vectors(const PathContext& context, const Vertex& v, FilmSample* out) {
  const HitVectorRequest& request = *context.vectors;
  const auto set = [&](Aov aov, const auto& value) {
    if (context.aovs & aov_bit(aov)) request.out->set(aov, value());
  };
  set(Aov::eye_point, [&] { return context.camera.to_eye(v.hit.p); });
  set(Aov::eye_normal, [&] { return context.camera.direction_to_eye(v.frame.n); });
  set(Aov::position, [&] { return Vec3f(Vec3d(v.hit.p) + context.scene.origin); });
  set(Aov::uv, [&] { return uv_of(v); });
  set(Aov::motion, [&] { return motion_of(request, v); });
  for (size_t i = 0; i < request.primvars.size(); ++i)
    set(primvar_aov(i), [&] { return primvar_at(v, request.primvars[i]); });
  out->vectors = request.out;
}

}  // namespace alabaster
