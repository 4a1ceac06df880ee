#include "core/geometry/mend_vectors.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/tangents.h"

namespace alabaster {
namespace {

bool is_direction(const Vec3f& v) {
  constexpr float kLeast = 0x1p-80f;  // of a squared length
  const float size = dot(v, v);
  return size > kLeast && std::isfinite(size);
}

Vec3d face_normal(const Mesh& mesh, size_t triangle) {
  const Corners& c = mesh.triangles[triangle];
  const Vec3d a(mesh.points[c[0]]), b(mesh.points[c[1]]), d(mesh.points[c[2]]);
  return cross(b - a, d - a);
}

const Corners& normal_corners_of(const Mesh& mesh, size_t triangle) {
  return mesh.normal_triangles.empty() ? mesh.triangles[triangle] : mesh.normal_triangles[triangle];
}

bool is_usable(const Vec4f& tangent, const Vec3d& normal) {
  constexpr double kLeastSine = 1e-3;
  const Vec3f t(tangent.x, tangent.y, tangent.z);
  if (!is_direction(t) || !(std::abs(tangent.w) > 0)) return false;
  const Vec3d across = cross(Vec3d(t), normal);
  return !(dot(normal, normal) > 0) ||
         dot(across, across) > kLeastSine * kLeastSine * dot(normal, normal) * double(dot(t, t));
}

/// Calls visit(triangle, corner, usable) for each corner.
template <class Visit>
void for_each_tangent(const Mesh& mesh, const Visit& visit) {
  const auto& tangents = mesh.tangents;
  for (size_t t = 0; t < mesh.triangles.size(); ++t)
    for (size_t i = 0; i < 3; ++i) {
      const uint32_t at = (tangents.triangles.empty() ? mesh.triangles[t] : tangents.triangles[t])[i];
      const Vec3d normal =
          mesh.normals.empty() ? face_normal(mesh, t) : Vec3d(mesh.normals[normal_corners_of(mesh, t)[i]]);
      visit(t, i, is_usable(tangents.values[at], normal));
    }
}

}  // namespace

bool are_usable(const std::vector<Vec3f>& normals) {
  return std::all_of(normals.begin(), normals.end(), is_direction);
}

MendedVectors mend_normals(Mesh* mesh) {
  MendedVectors mended;
  std::vector<Vec3d> sums;
  std::vector<Vec3f>& normals = mesh->normals;
  for (size_t t = 0; t < mesh->triangles.size() && !normals.empty(); ++t)
    for (const uint32_t at : normal_corners_of(*mesh, t)) {
      if (is_direction(normals[at])) continue;
      if (sums.empty()) sums.resize(normals.size(), Vec3d(0, 0, 0)), mended.element = mesh->element(uint32_t(t));
      sums[at] += face_normal(*mesh, t);
    }
  for (size_t i = 0; i < sums.size(); ++i) {
    if (is_direction(normals[i])) continue;
    const double l = length(sums[i]);
    normals[i] = l > 0 ? Vec3f(sums[i] / l) : Vec3f(0, 0, 0);
    ++mended.count;
  }
  return mended;
}

MendedVectors find_unusable_tangents(const Mesh& mesh) {
  MendedVectors found;
  if (mesh.tangents.empty()) return found;
  for_each_tangent(mesh, [&](size_t triangle, size_t, bool usable) {
    if (!usable && found.count++ == 0) found.element = mesh.element(uint32_t(triangle));
  });
  return found;
}

void mend_tangents(Mesh* mesh, size_t unusable) {
  if (unusable == 0) return;
  if (unusable == 3 * mesh->triangles.size() || mesh->uv_sets.empty()) {
    mesh->tangents = {};
    return;
  }
  const MeshAttribute<Vec4f> made = compute_tangents(*mesh, mesh->uv_sets.front());
  MeshAttribute<Vec4f> mixed = mesh->tangents;
  if (mixed.triangles.empty()) mixed.triangles = mesh->triangles;
  const auto first = static_cast<uint32_t>(mixed.values.size());
  for_each_tangent(*mesh, [&](size_t triangle, size_t corner, bool usable) {
    if (!usable) mixed.triangles[triangle][corner] = first + made.triangles[triangle][corner];
  });
  mixed.values.insert(mixed.values.end(), made.values.begin(), made.values.end());
  mesh->tangents = std::move(mixed);
}

}  // namespace alabaster
