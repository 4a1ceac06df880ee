#include "core/integrator/hit_vectors.h"

namespace alabaster {
namespace {

// The point of the surface that was hit, in render space, at another time.
Vec3f point_at(const Vertex& v, float time) {
  const auto [a, b, c] = v.instance->prototype->mesh.corners_at(v.triangle.triangle, time);
  const Vec3f p = a * (1 - v.triangle.u - v.triangle.v) + b * v.triangle.u + c * v.triangle.v;
  TriangleHit then = v.triangle;
  then.time = time;
  std::optional<Placement> moved;
  return v.instance->at(then, &moved).object_to_world.point(p);
}

// x to the right and y up, as rows of buffers go. Zero where the point is behind the camera at either time.
Vec3f motion_of(const HitVectorRequest& request, const Vertex& v) {
  const auto from = request.opens.project(point_at(v, request.open_time));
  const auto to = request.closes.project(point_at(v, request.close_time));
  return from && to ? Vec3f(to->x - from->x, from->y - to->y, 0) : Vec3f(0, 0, 0);
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
  set(Aov::motion, [&] { return motion_of(request, v); });
  for (size_t i = 0; i < request.primvars.size(); ++i)
    set(primvar_aov(i), [&] { return primvar_at(v, request.primvars[i]); });
  out->vectors = request.out;
}

}  // namespace alabaster
