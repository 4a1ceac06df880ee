// Bodies that are only a medium, and a comparison of two pictures of them, for tests of subsurface geometry.
#pragma once

#include <gtest/gtest.h>

#include <array>

#include "testenv/support/scene_builder.h"
#include "testenv/support/z_test.h"

namespace alabaster::testing {

inline constexpr double kExit = 41.0 / 42;  // mass of the exit lobe: 1 - 1/42

inline DisneyParameters medium_only(float albedo, float scatter_distance) {
  DisneyParameters p;
  p.base_color = Rgb(albedo);
  p.roughness = 0;
  p.ior = 1;
  p.specular = 0;
  p.scatter_distance = Rgb(scatter_distance);
  return p;
}

// An axis-aligned box, each side of `steps` by `steps` quads.
inline Mesh box_mesh(const Vec3f& lower, const Vec3f& upper, int steps = 1) {
  Mesh mesh;
  for (int axis = 0; axis < 3; ++axis)
    for (const bool top : {false, true}) {
      const auto first = static_cast<uint32_t>(mesh.points.size());
      const auto n = static_cast<uint32_t>(steps + 1);
      for (int j = 0; j <= steps; ++j)
        for (int i = 0; i <= steps; ++i) {
          Vec3f p;
          const int u = (axis + 1) % 3, v = (axis + 2) % 3;
          p[axis] = top ? upper[axis] : lower[axis];
          p[u] = i == steps ? upper[u]
                            : lower[u] + (upper[u] - lower[u]) * static_cast<float>(i) / static_cast<float>(steps);
          p[v] = j == steps ? upper[v]
                            : lower[v] + (upper[v] - lower[v]) * static_cast<float>(j) / static_cast<float>(steps);
          mesh.points.push_back(p);
        }
      for (uint32_t j = 0; j + 1 < n; ++j)
        for (uint32_t i = 0; i + 1 < n; ++i) {
          const uint32_t a = first + j * n + i, b = a + 1, c = a + n + 1, d = a + n;
          for (std::array<uint32_t, 3> t : {std::array<uint32_t, 3>{a, b, c}, {a, c, d}}) {
            if (!top) std::swap(t[1], t[2]);
            mesh.triangles.push_back(t);
          }
        }
    }
  for (const Vec3f& p : mesh.points) mesh.bounds.extend(p);
  mesh.closed = mesh.outward = true;
  return mesh;
}

inline Mesh merged(Mesh a, const Mesh& b) {
  const auto first = static_cast<uint32_t>(a.points.size());
  a.points.insert(a.points.end(), b.points.begin(), b.points.end());
  for (auto t : b.triangles) a.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  a.bounds.extend(b.bounds);
  return a;
}

inline RenderRequest request_of(SceneBuilder* b, const CameraParameters& camera, uint32_t samples, int size = 32) {
  RenderRequest request;
  request.scene = b->snapshot();
  request.camera = camera;
  request.width = request.height = size;
  request.data_window = {0, 0, size, size};
  request.settings.samples = samples;
  request.settings.filter = PixelFilter::box;
  return request;
}

// Two films of the same scene, each pixel its own experiment: tests that their means agree in each of four quarters.
inline std::array<ZTestResult, 4> compare_quarters(const Film& a, const Film& b) {
  const auto x = a.resolve_float(Aov::color), y = b.resolve_float(Aov::color);
  const int size = a.data_window().width();
  RunningStatistics quarters[4];
  for (int i = 0; i < size * size; ++i) {
    const size_t q = (i % size < size / 2 ? 0u : 1u) + (i / size < size / 2 ? 0u : 2u);
    quarters[q].add(x[4 * static_cast<size_t>(i) + 1] - y[4 * static_cast<size_t>(i) + 1]);
  }
  return {z_test(quarters[0], 0), z_test(quarters[1], 0), z_test(quarters[2], 0), z_test(quarters[3], 0)};
}

inline void expect_same(const Film& a, const Film& b, const char* what) {
  for (const ZTestResult& quarter : compare_quarters(a, b)) EXPECT_TRUE(plausible(quarter)) << what;
}

/// A translation along x.
inline Matrix4d moved(double x) {
  return Matrix4d().setTranslation(Vec3d(x, 0, 0));
}

}  // namespace alabaster::testing
