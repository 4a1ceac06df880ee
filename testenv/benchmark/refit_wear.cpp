// How much slower rays are through a hierarchy that was built for other points of the same triangles.
//   refit_wear [--level N]
// A sphere is built, bent out of shape and its hierarchy fitted to the new points, whatever it is worn. Beside it
// stands one that is built for them. CPU time of both, and of rays from without and within. Prints Markdown.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <limits>

#include "core/geometry/edited_object.h"
#include "core/geometry/hierarchy_cost.h"
#include "testenv/support/cages.h"

namespace alabaster {
namespace {

constexpr int kRays = 400000, kTurns = 3;

double cpu_ms() {
  return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

double trace_ms(const ObjectScene& object) {
  const double begun = cpu_ms();
  for (int i = 0; i < kRays; ++i) {
    const auto share = [i](double step) { return static_cast<float>(std::fmod(0.5 + i * step, 1.0)) * 2 - 1; };
    const Vec3f to(share(0.8191725134), share(0.6710436067), share(0.5497004779));
    const Vec3f from(share(0.7548776662), share(0.5698402910), 3);
    TriangleHit hit;
    object.intersect({i % 2 ? from : to * 0.2f, i % 2 ? to - from : to}, &hit);
  }
  return cpu_ms() - begun;
}

using Bend = Vec3f (*)(const Vec3f&, float);

Vec3f twist(const Vec3f& p, float by) {
  const float c = std::cos(by * p.z), s = std::sin(by * p.z);
  return {p.x * c - p.y * s, p.x * s + p.y * c, p.z};
}
Vec3f wave(const Vec3f& p, float by) {
  return {p.x + by * std::sin(6 * p.y), p.y, p.z};
}
Vec3f turn(const Vec3f& p, float by) {
  return twist({p.x, p.y, 1}, by) + Vec3f(0, 0, p.z - 1);
}
Vec3f bumps(const Vec3f& p, float by) {
  return p * (1 + by * std::sin(60 * p.x) * std::sin(50 * p.y));
}
Vec3f stretch(const Vec3f& p, float by) {
  return {p.x * (1 + by), p.y, p.z};
}

void row(const Mesh& rest, const char* name, Bend bend, float by) {
  const auto device = make_trace_device({});
  Mesh bent = rest;
  bent.bounds = {};
  for (Vec3f& p : bent.points) bent.bounds.extend(p = bend(p, by));
  const TriangleGroups groups(rest);
  EditedObject edited(std::numeric_limits<double>::infinity());
  edited.build(device, rest);  // and lets go of it
  const double begun = cpu_ms();
  const auto fitted = edited.build(device, bent);
  const double fitted_at = cpu_ms();
  const auto built = build_object_scene(device, bent, {});
  const double built_at = cpu_ms();
  double slow = 0, fast = 0;
  for (int i = 0; i < kTurns; ++i) slow += trace_ms(*fitted), fast += trace_ms(*built);
  std::printf("| %s %.2f | %.2f | %.2f | %.1f | %.1f |\n", name, static_cast<double>(by),
              groups.cost(bent) / groups.cost(rest), slow / fast, fitted_at - begun, built_at - fitted_at);
  std::fflush(stdout);
}

void run(int level) {
  RefinementOptions options;
  options.level = level;
  Mesh sphere = build_mesh(test::cube_cage(SubdivisionScheme::catmull_clark), options, {});
  sphere.bounds = {};
  for (Vec3f& p : sphere.points) sphere.bounds.extend(p = normalize(p));
  std::printf("%zu triangles.\n\n", sphere.triangles.size());
  std::printf("| shape | cost | time of rays | fitted, ms | built, ms |\n|---|---|---|---|---|\n");
  row(sphere, "as it was", stretch, 0);
  for (const float by : {0.2f, 0.4f, 0.7f, 1.0f, 1.5f}) row(sphere, "twisted", twist, by);
  for (const float by : {0.1f, 0.3f, 0.6f}) row(sphere, "waved", wave, by);
  for (const float by : {0.1f, 0.3f, 0.6f, 1.0f}) row(sphere, "turned", turn, by);
  for (const float by : {0.01f, 0.03f, 0.1f}) row(sphere, "bumpy", bumps, by);
  for (const float by : {0.3f, 1.0f}) row(sphere, "stretched", stretch, by);
}

}  // namespace
}  // namespace alabaster

int main(int argc, char** argv) {
  int level = 7;
  for (int i = 1; i + 1 < argc; i += 2)
    if (!std::strcmp(argv[i], "--level")) level = std::clamp(std::atoi(argv[i + 1]), 1, 8);
  alabaster::run(level);
  return 0;
}
