#include "delegate/description/placement.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <utility>

#include "core/math/bounds.h"
#include "core/math/transform.h"
#include "delegate/description/render_description.h"
#include "delegate/support/float_values.h"
#include "delegate/support/instancing.h"
#include "delegate/support/lookup.h"

namespace alabaster::hd::description {
namespace {

using nlohmann::json;

Matrix4d axis_rotation(int axis, double degrees) {
  const double a = degrees * std::numbers::pi / 180, c = std::cos(a), s = std::sin(a);
  const int i = (axis + 1) % 3, j = (axis + 2) % 3;
  Matrix4d m;
  m[i][i] = c;
  m[i][j] = s;
  m[j][i] = -s;
  m[j][j] = c;
  return m;
}

bool finite(const Vec3d& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

// True if some triangle of the face's fan has an area.
bool has_area(const Array<Vec3f>& points, const int32_t* corners, int32_t count) {
  const auto point = [&](int32_t i) {
    const auto at = static_cast<size_t>(corners[i]);
    return corners[i] >= 0 && at < points.size() ? Vec3d(points[at]) : Vec3d(0);
  };
  for (int32_t i = 2; i < count; ++i)
    if ((point(i - 1) - point(0)).cross(point(i) - point(0)).length2() > 0) return true;
  return false;
}

// Around each point, of curves and points, whose greatest width counts for all.
std::vector<Vec3f> points_around(const Array<Vec3f>& points, const host::MeshDescription& mesh) {
  const auto primvar = mesh.primvars.find("widths");
  const Value value = primvar == mesh.primvars.end() ? Value() : support::FloatValues(primvar->second.value);
  const auto* widths = value.get<Array<float>>();
  float radius = widths ? 0.0f : 0.5f;
  for (size_t i = 0; widths && i < widths->size(); ++i)
    if (std::isfinite((*widths)[i])) radius = std::max(radius, (*widths)[i] / 2);
  std::vector<Vec3f> around;
  for (const Vec3f& p : points) {
    if (!is_finite(p)) continue;
    for (int axis = 0; axis < 3; ++axis) {
      Vec3f out(0);
      out[axis] = radius;
      around.insert(around.end(), {p - out, p + out});
    }
  }
  return around;
}

// The points of the faces that are drawn.
std::vector<Vec3f> drawn_points(const host::MeshDescription& mesh) {
  const auto primvar = mesh.primvars.find("points");
  const Value value = primvar == mesh.primvars.end() ? Value() : support::FloatValues(primvar->second.value);
  const auto* points = value.get<Array<Vec3f>>();
  const MeshTopology& topology = mesh.topology;
  if (!points) return {};
  if (!(mesh.type == Token("mesh"))) return points_around(*points, mesh);
  std::vector<char> is_hidden(topology.faceVertexCounts.size(), 0), is_drawn(points->size(), 0);
  for (const auto* faces : {&topology.holeIndices, &topology.invisibleFaces})
    for (const int32_t face : *faces)
      if (face >= 0 && static_cast<size_t>(face) < is_hidden.size()) is_hidden[static_cast<size_t>(face)] = 1;
  size_t corner = 0;
  for (size_t face = 0; face < is_hidden.size(); ++face) {
    const auto left = static_cast<int32_t>(
        std::min<size_t>(topology.faceVertexIndices.size() - corner, std::numeric_limits<int32_t>::max()));
    const int32_t count = std::clamp(topology.faceVertexCounts[face], 0, left);
    const int32_t* const corners = topology.faceVertexIndices.data() + corner;
    corner += static_cast<size_t>(count);
    if (is_hidden[face] || !has_area(*points, corners, count)) continue;
    for (const int32_t point : std::span(corners, static_cast<size_t>(count)))
      if (point >= 0 && static_cast<size_t>(point) < is_drawn.size()) is_drawn[static_cast<size_t>(point)] = 1;
  }
  std::vector<Vec3f> drawn;
  for (size_t i = 0; i < is_drawn.size(); ++i)
    if (is_drawn[i] && is_finite((*points)[i])) drawn.push_back((*points)[i]);
  return drawn;
}

/// Calls visit(point) for the points of a mesh in the world, or of many instances for the corners of their boxes.
/// Instances that cannot be drawn count for nothing.
template <class Visit>
void for_each_point(const host::MeshDescription& mesh, const support::PlacementSource& instances, const Visit& visit) {
  const auto placed = [&](size_t i) -> std::optional<Matrix4d> {
    const support::Placement one = instances[i];
    return one.used && is_valid_affine(mesh.transform * one.matrix) ? std::optional(one.matrix) : std::nullopt;
  };
  int drawn = 0;
  for (size_t i = 0; i < instances.size() && drawn < 2; ++i) drawn += placed(i).has_value();
  if (drawn == 0) return;
  std::vector<Vec3f> points = drawn_points(mesh);
  if (drawn > 1) {
    Bounds box;
    for (const Vec3f& p : points) box.extend(p);
    points.clear();
    for (const Vec3f& corner : box.corners())
      if (!box.empty()) points.push_back(corner);
  }
  for (size_t i = 0; i < instances.size() && !points.empty(); ++i)
    if (const auto instance = placed(i))
      for (const Vec3f& p : points)
        if (const Vec3d world = Vec3d(p) * mesh.transform * *instance; finite(world)) visit(world);
}

// Camera axes of the three-quarter view: seen from 35 degrees to the right and 18 degrees above the front (+z).
Matrix4d three_quarter_axes() {
  const double azimuth = 35 * std::numbers::pi / 180, elevation = 18 * std::numbers::pi / 180;
  const Vec3d eye(std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
                  std::cos(azimuth) * std::cos(elevation));
  Matrix4d axes = *look_at(eye, Vec3d(0), Vec3d(0, 1, 0), false);
  axes[3][0] = axes[3][1] = axes[3][2] = 0;
  return axes;
}

}  // namespace

Vec3d to_vec3d(const json& value) {
  return {value[0].get<double>(), value[1].get<double>(), value[2].get<double>()};
}

std::optional<Matrix4d> to_transform(const json& value) {
  Matrix4d m;
  if (value.is_array()) {
    for (int i = 0; i < 16; ++i) m[i / 4][i % 4] = value[static_cast<size_t>(i)].get<double>();
  } else {
    if (value.contains("scale")) m = Matrix4d().setScale(to_vec3d(value["scale"]));
    if (value.contains("rotate")) {
      const Vec3d degrees = to_vec3d(value["rotate"]);
      for (int axis = 0; axis < 3; ++axis) m = m * axis_rotation(axis, degrees[axis]);
    }
    if (value.contains("translate")) m = m * Matrix4d().setTranslation(to_vec3d(value["translate"]));
  }
  return is_valid_affine(m) ? std::optional(m) : std::nullopt;
}

namespace {

// Of rows: y goes up, and z, which comes towards the viewer, against y.
const Matrix4d kToZUp(1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1);

}  // namespace

Vec3d up_vector(const Token& up) {
  return up == Token("Z") ? Vec3d(0, 0, 1) : Vec3d(0, 1, 0);
}
Matrix4d to_world(const Matrix4d& placed, const Token& up) {
  return up == Token("Z") ? placed * kToZUp : placed;
}
Matrix4d from_world(const Matrix4d& placed, const Token& up) {
  return up == Token("Z") ? placed * kToZUp.transposed() : placed;
}
std::vector<Vec3d> from_world(std::vector<Vec3d> points, const Token& up) {
  if (up == Token("Z"))
    for (Vec3d& p : points) p = {p.x, p.z, -p.y};
  return points;
}

std::optional<Matrix4d> look_at(const Vec3d& eye, const Vec3d& target, const Vec3d& up, bool free_up) {
  Vec3d z = eye - target;
  const double distance = z.length();
  if (!(distance > 0) || !std::isfinite(distance)) return std::nullopt;
  z /= distance;
  Vec3d x = up.cross(z);
  if (!(x.length() > 1e-9 * up.length())) {
    if (!free_up) return std::nullopt;
    x = (std::abs(z.y) > 0.5 ? Vec3d(0, 0, -1) : Vec3d(0, 1, 0)).cross(z);
  }
  x.normalize();
  const Vec3d y = z.cross(x);
  return Matrix4d(x.x, x.y, x.z, 0, y.x, y.y, y.z, 0, z.x, z.y, z.z, 0, eye.x, eye.y, eye.z, 1);
}

namespace {

/// Instances of instancers that place others: those of more are not measured.
constexpr size_t kMostPlaced = size_t(1) << 22;
/// Instances of a mesh whose boxes are kept one by one.
constexpr size_t kMostBoxes = size_t(1) << 16;

/// Calls visit(path, mesh, instances) for each mesh that `takes` takes.
template <class Takes, class Visit>
void for_each_placed_mesh(host::RetainedSceneDelegate& scene, const Takes& takes, const Visit& visit) {
  std::map<Path, support::InstancerRecord> instancers;
  for (const auto& [path, description] : scene.GetInstancers())
    instancers[path] = support::pull_instancer(scene, path, {});
  const auto limit = [](size_t count, const Path& prototype) -> std::shared_ptr<const void> {
    if (count > kMostPlaced) throw support::TooManyInstances(prototype);
    return nullptr;
  };
  // Sync reports what is wrong.
  support::Placements placements([&](const Path& path) { return support::find_in(instancers, path); }, {}, limit);
  const auto once = std::make_shared<const std::vector<support::Placement>>(1);
  for (const auto& [path, mesh] : scene.GetMeshes()) {
    if (!takes(mesh)) continue;
    support::PlacementSource instances{nullptr, {0}, once};
    if (!mesh.instancer.empty()) {
      try {
        instances = placements.source(path, mesh.instancer, scene.GetInstanceIndices(mesh.instancer, path));
      } catch (const support::TooManyInstances&) {
        instances = {};  // Sync reports it, and leaves the mesh out
      }
    }
    visit(path, mesh, instances);
  }
}

}  // namespace

std::vector<Vec3d> enclosing_points(host::RetainedSceneDelegate& scene) {
  std::vector<Vec3d> all;
  const auto is_visible = [](const host::MeshDescription& mesh) { return mesh.visible; };
  for_each_placed_mesh(scene, is_visible, [&](const Path&, const auto& mesh, const auto& instances) {
    if (instances.size() <= kMostBoxes)
      return for_each_point(mesh, instances, [&](const Vec3d& p) { all.push_back(p); });
    BoundsDouble box;
    for_each_point(mesh, instances, [&](const Vec3d& p) { box.extend(p); });
    for (const Vec3d& corner : box.corners())
      if (!box.empty()) all.push_back(corner);
  });
  return all;
}

std::map<Path, WorldBox> MeshBoxes(host::RetainedSceneDelegate& scene) {
  std::map<Path, WorldBox> boxes;
  const auto any = [](const host::MeshDescription&) { return true; };
  for_each_placed_mesh(scene, any, [&](const Path& path, const auto& mesh, const auto& instances) {
    BoundsDouble box;
    for_each_point(mesh, instances, [&](const Vec3d& p) { box.extend(p); });
    boxes[path] = {box.lower, box.upper};
  });
  return boxes;
}

// In camera axes a point (x, y, z) is inside if |x - cx| <= t (cz - z), with t the tangent of the half-angle. With A =
// max(x + t z) and B = max(-x + t z), the nearest such camera has cx = (A - B) / 2 and cz = (A + B) / (2 t).
Framed frame_points(const std::vector<Vec3d>& points, const Frustum& frustum) {
  constexpr double kMargin = 0.86;
  const Matrix4d axes = three_quarter_axes(), to_camera = axes.transposed();
  const double low = -std::numeric_limits<double>::infinity();
  const double tangent[2] = {frustum.tan_x * kMargin, frustum.tan_y * kMargin};
  double plus[2] = {low, low}, minus[2] = {low, low};
  BoundsDouble box;
  for (const Vec3d& world : points) {
    const Vec3d p = world * to_camera;
    box.extend(p);
    for (int i = 0; i < 2; ++i) {
      plus[i] = std::max(plus[i], p[i] + tangent[i] * p.z);
      minus[i] = std::max(minus[i], -p[i] + tangent[i] * p.z);
    }
  }
  Framed framed;
  Vec3d position(0, 0, 3);
  if (!points.empty()) {
    const double needed_x = (plus[0] + minus[0]) / (2 * tangent[0]), needed_y = (plus[1] + minus[1]) / (2 * tangent[1]);
    position = {(plus[0] - minus[0]) / 2, (plus[1] - minus[1]) / 2, std::max(needed_x, needed_y)};
    const double size = length(box.extent());
    if (!(size > 0)) position.z += 1;  // a single point is in view at any distance
    framed.distance = position.z - box.center().z;
  } else {
    framed.distance = 3;
  }
  framed.camera = axes * Matrix4d().setTranslation(position * axes);
  return framed;
}

}  // namespace alabaster::hd::description
