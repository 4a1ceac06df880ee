// Adaptive against uniform refinement: triangles, CPU time of building, and how far silhouettes are off.
//   adaptive_refinement [--size PIXELS]
// Bodies of the same cage stand from 1 to 60 units before a camera, each a mesh of its own. The error is the area, in
// pixels, in which the bodies' outlines differ from those at level 8, sampled by 4 x 4 rays in each pixel: their sum,
// and that of the body that is off most. Prints Markdown.

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <string>

#include "core/geometry/embree_scene.h"
#include "testenv/support/cages.h"

namespace alabaster {
namespace {

constexpr int kBodies = 10, kRays = 4;
constexpr float kView = 0.9f;  // the picture's side at distance 1

// Each is seen alone, in the middle of the picture.
struct Body {
  float distance;
  Vec3f turn;  // of the cage, so that outlines differ
};

Body body(int i) {
  const float t = static_cast<float>(i) / (kBodies - 1);
  return {std::pow(60.0f, t), {0.3f * t, 1 - t, 0.5f}};
}

Cage cage_of(const Body& b) {
  Cage cage = test::cube_cage(SubdivisionScheme::catmull_clark);
  const Vec3f z = normalize(b.turn + Vec3f(0.1f, 0.2f, 0.9f)), x = normalize(cross(Vec3f(0, 1, 0), z)), y = cross(z, x);
  for (Vec3f& p : cage.points) p = (x * p.x + y * (0.6f * p.y) + z * p.z) * 0.3f - Vec3f(0, 0, b.distance);
  return cage;
}

struct Outline {
  std::vector<bool> hits[kBodies];  // of the rays through the square that holds each
  size_t triangles = 0;
  double seconds = 0;
};

Outline outline(const RefinementOptions& options, int size) {
  const auto device = make_trace_device({});
  Outline out;
  for (int i = 0; i < kBodies; ++i) {
    const Body b = body(i);
    const Cage cage = cage_of(b);
    const std::clock_t start = std::clock();
    const Mesh mesh = build_mesh(cage, options, {});
    const auto object = build_object_scene(device, mesh, {});
    out.seconds += double(std::clock() - start) / CLOCKS_PER_SEC;
    out.triangles += mesh.triangles.size();
    const float pixels = static_cast<float>(size) / kView, half = 0.4f / b.distance;
    const int rays = static_cast<int>(2 * half * pixels * kRays) + 1;
    for (int y = 0; y < rays; ++y)
      for (int x = 0; x < rays; ++x) {
        const auto at = [&](int k) { return (static_cast<float>(k) + 0.5f) / (pixels * kRays) - half; };
        TriangleHit hit;
        out.hits[i].push_back(object->intersect({Vec3f(0, 0, 0), Vec3f(at(x), at(y), -1)}, &hit));
      }
  }
  return out;
}

void print(const std::string& name, const Outline& o, const Outline& reference) {
  double sum = 0, worst = 0;
  for (int i = 0; i < kBodies; ++i) {
    size_t differ = 0;
    for (size_t k = 0; k < o.hits[i].size(); ++k) differ += o.hits[i][k] != reference.hits[i][k];
    const double area = double(differ) / (kRays * kRays);
    sum += area;
    worst = std::max(worst, area);
  }
  std::printf("| %s | %zu | %.3f | %.1f | %.1f |\n", name.c_str(), o.triangles, o.seconds, sum, worst);
}

}  // namespace

int run(int size) {
  RefinementOptions uniform;
  uniform.level = 8;
  const Outline reference = outline(uniform, size);
  std::printf("| refinement | triangles | CPU s | outlines off by, pixels | of the worst body |\n|--|--|--|--|--|\n");
  for (uniform.level = 1; uniform.level < 8; ++uniform.level)
    print("level " + std::to_string(uniform.level), outline(uniform, size), reference);
  for (const float edge : {32.0f, 16.0f, 8.0f, 4.0f, 2.0f, 1.0f}) {
    RefinementOptions adaptive;
    adaptive.level = 1;
    const float pixel = edge * kView / static_cast<float>(size);
    adaptive.segments = [pixel](const Vec3f& a, const Vec3f& b) {
      return length(b - a) / (pixel * length((a + b) * 0.5f));
    };
    print("edges of " + std::to_string(int(edge)) + " pixels", outline(adaptive, size), reference);
  }
  return 0;
}

}  // namespace alabaster

int main(int argc, char** argv) {
  const bool given = argc == 3 && std::strcmp(argv[1], "--size") == 0;
  return alabaster::run(given ? std::atoi(argv[2]) : 1024);
}
