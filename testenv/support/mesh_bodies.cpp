#include "testenv/support/mesh_bodies.h"

#include <algorithm>
#include <cmath>

namespace alabaster::testing {
namespace {

Vec3d corner(const Mesh& mesh, size_t triangle, size_t index) {
  const Vec3f& p = mesh.points[mesh.triangles[triangle][index]];
  return {p.x, p.y, p.z};
}

double triangle_area(const Mesh& mesh, size_t triangle) {
  const Vec3d a = corner(mesh, triangle, 0);
  return 0.5 * length(cross(corner(mesh, triangle, 1) - a, corner(mesh, triangle, 2) - a));
}

void complete(Mesh* mesh) {
  mesh->closed = mesh->outward = true;
  for (const Vec3f& p : mesh->points) mesh->bounds.extend(p);
  for (size_t i = 0; i < mesh->triangles.size(); ++i) mesh->triangle_face.push_back(static_cast<int32_t>(i));
}

}  // namespace

Mesh box_mesh(const Vec3f& h) {
  Mesh mesh;
  const auto corners = Bounds{-h, h}.corners();
  mesh.points.assign(corners.begin(), corners.end());
  constexpr uint32_t kQuads[6][4] = {{2, 6, 7, 3}, {0, 1, 5, 4}, {0, 2, 3, 1},
                                     {4, 5, 7, 6}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& q : kQuads) {
    mesh.triangles.push_back({q[0], q[1], q[2]});
    mesh.triangles.push_back({q[0], q[2], q[3]});
  }
  complete(&mesh);
  return mesh;
}

Mesh torus_mesh(float radius, float tube_radius, int segments) {
  Mesh mesh;
  const int across = segments / 2;
  for (int i = 0; i < segments; ++i)
    for (int j = 0; j < across; ++j) {
      const double phi = 2 * M_PI * i / segments, theta = 2 * M_PI * j / across;
      const double r = static_cast<double>(radius) + static_cast<double>(tube_radius) * std::cos(theta);
      mesh.points.emplace_back(static_cast<float>(r * std::cos(phi)),
                               static_cast<float>(static_cast<double>(tube_radius) * std::sin(theta)),
                               static_cast<float>(r * std::sin(phi)));
    }
  const auto index = [&](int i, int j) { return static_cast<uint32_t>((i % segments) * across + j % across); };
  for (int i = 0; i < segments; ++i)
    for (int j = 0; j < across; ++j) {
      mesh.triangles.push_back({index(i, j), index(i, j + 1), index(i + 1, j + 1)});
      mesh.triangles.push_back({index(i, j), index(i + 1, j + 1), index(i + 1, j)});
    }
  complete(&mesh);
  return mesh;
}

double mesh_area(const Mesh& mesh) {
  double sum = 0;
  for (size_t i = 0; i < mesh.triangles.size(); ++i) sum += triangle_area(mesh, i);
  return sum;
}

double mesh_volume(const Mesh& mesh) {
  double sum = 0;
  for (size_t i = 0; i < mesh.triangles.size(); ++i)
    sum += dot(corner(mesh, i, 0), cross(corner(mesh, i, 1), corner(mesh, i, 2))) / 6;
  return sum;
}

SurfaceSampler::SurfaceSampler(const Mesh& mesh, const std::function<bool(size_t)>& included) {
  double sum = 0;
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (!included || included(i)) sum += triangle_area(mesh, i);
    area_up_to_.push_back(sum);
  }
}

TriangleHit SurfaceSampler::sample(const std::array<float, 3>& u) const {
  const double wanted = static_cast<double>(u[0]) * area_up_to_.back();
  const auto found = std::upper_bound(area_up_to_.begin(), area_up_to_.end(), wanted);
  TriangleHit hit;
  hit.triangle = static_cast<uint32_t>(std::min(found, area_up_to_.end() - 1) - area_up_to_.begin());
  const float root = std::sqrt(u[1]);
  hit.u = root * (1 - u[2]);
  hit.v = root * u[2];
  return hit;
}

}  // namespace alabaster::testing
