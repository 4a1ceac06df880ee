#include "core/integrator/path_record.h"

#include "core/diagnostics/plain_format.h"
#include "core/integrator/direct_light.h"
#include "core/scene/scene.h"

namespace alabaster {
namespace {

std::string three(double x, double y, double z) {
  return plain_format("(%.9g %.9g %.9g)", x, y, z);
}
std::string three(const Vec3f& v) {
  return three(v.x, v.y, v.z);
}
std::string three(const Rgb& c) {
  return three(c.r, c.g, c.b);
}

const char* name_of(WalkStep::Kind kind) {
  switch (kind) {
    case WalkStep::Kind::scatter:
      return "scatter";
    case WalkStep::Kind::sphere_step:
      return "sphere step";
    case WalkStep::Kind::exit:
      break;
  }
  return "surface";
}

}  // namespace

void PathRecord::line(int indent, const std::string& text) {
  finish_light();
  text_.append(static_cast<size_t>(indent), ' ').append(text).append("\n");
}

void PathRecord::finish_light() {
  if (light_is_open_) text_.append("; shadowed\n");
  light_is_open_ = false;
}

std::string PathRecord::position(const Vec3f& p) const {
  return three(origin_.x + double(p.x), origin_.y + double(p.y), origin_.z + double(p.z));
}

std::string PathRecord::surface(const Instance& instance, const TriangleHit& triangle, const SurfaceHit& hit) const {
  return plain_format("primId %d, instanceId %d, elementId %d, triangle %u, material '", instance.prim_id,
                      instance.id_of(triangle), instance.prototype->mesh.element(triangle.triangle),
                      triangle.triangle) +
         instance.material(triangle.triangle).name + "' at " + position(hit.p) + ", ng " + three(hit.ng) + ", ns " +
         three(hit.ns) + plain_format(", uv (%.9g %.9g)", double(hit.uv.x), double(hit.uv.y));
}

void PathRecord::follow(const Ray& ray, const Rgb& throughput, float pdf) {
  check(throughput, NonfiniteCause::lobe);
  if (!is_written_) return;
  line(0, "ray from " + position(ray.org) + " towards " + three(ray.dir) + ", throughput " + three(throughput) +
              (pdf > 0 ? plain_format(", pdf %.9g", double(pdf)) : std::string()));
}

void PathRecord::meet_light(const Rgb& light) {
  check(light, NonfiniteCause::emission);
  if (is_written_ && !is_black(light)) line(2, "meets light, adds " + three(light));
}

void PathRecord::meet_surface(const Instance& instance, const TriangleHit& triangle, const SurfaceHit& hit) {
  if (!is_written_) return;
  line(0,
       plain_format("vertex %d, distance %.9g: ", vertices_++, double(triangle.t)) + surface(instance, triangle, hit));
}

void PathRecord::sample_light(const Vec3f& wi, const Rgb& f_cos, float pdf) {
  check(f_cos, NonfiniteCause::lobe);
  if (!is_written_) return;
  finish_light();
  text_ += "  light towards " + three(wi) + ": f cos " + three(f_cos) + plain_format(", lobe pdf %.9g", double(pdf));
  light_is_open_ = !is_black(f_cos);
  if (!light_is_open_) text_ += "\n";
}

void PathRecord::light_arrives(const Rgb& light, const LightWeight& weight) {
  check(light, NonfiniteCause::light);
  if (!is_written_) return;
  text_ += plain_format(", light pdf %.9g, weight %.9g", double(weight.pdf), double(weight.mis)) + "; adds " +
           three(light) + "\n";
  light_is_open_ = false;
}

void PathRecord::sample_lobe(const char* lobe, const Rgb& f_cos, float pdf) {
  check(f_cos, NonfiniteCause::lobe);
  if (!is_written_) return;
  line(2,
       std::string("samples the lobe ") + lobe + ": f cos " + three(f_cos) + plain_format(", pdf %.9g", double(pdf)));
}

void PathRecord::write_walk() {
  for (const WalkStep& step : walk_)
    line(4,
         std::string(name_of(step.kind)) + plain_format(" after %.9g towards ", step.distance) + three(step.direction));
  walk_.clear();
}

void PathRecord::leave_body(const Instance& instance, const TriangleHit& triangle, const SurfaceHit& hit,
                            const Rgb& throughput) {
  check(throughput, NonfiniteCause::walk);
  if (!is_written_) return;
  write_walk();
  line(2, "leaves the body at " + surface(instance, triangle, hit) + ", throughput " + three(throughput));
}

void PathRecord::add_flat_light(const Rgb& light) {
  check(light, NonfiniteCause::light);
  if (is_written_ && !is_black(light)) line(2, "adds " + three(light) + ", as if the body filled a half-space");
}

void PathRecord::twin_leaves(const Rgb& light) {
  check(light, NonfiniteCause::walk);
  if (is_written_) line(2, "adds " + three(light) + ", for what the same walk brings out of a half-space");
}

void PathRecord::branch(uint32_t index, uint32_t count) {
  if (!is_written_) return;
  if (index == 0) vertices_before_split_ = vertices_;
  vertices_ = vertices_before_split_;
  line(0, plain_format("path %u of %u, which counts 1/%u:", index + 1, count, count));
}

void PathRecord::end(const char* reason) {
  if (!is_written_) return;
  write_walk();
  line(0, std::string("ends: ") + reason);
}

}  // namespace alabaster
