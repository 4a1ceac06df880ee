#include "delegate/prims/points.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "core/math/vector.h"
#include "delegate/prims/motion.h"

namespace alabaster::hd::prims {
namespace {

struct Sphere {
  Array<int32_t> counts, corners;
  Array<Vec3f> points, normals;
};

// An icosahedron whose faces are halved four times.
Sphere make_sphere() {
  const double g = (1 + std::sqrt(5.0)) / 2;
  std::vector<Vec3d> points{{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                            {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  std::vector<int32_t> corners{0, 11, 5,  0, 5,  1, 0, 1, 7, 0, 7,  10, 0, 10, 11, 1, 5, 9, 5, 11,
                               4, 11, 10, 2, 10, 7, 6, 7, 1, 8, 3,  9,  4, 3,  4,  2, 3, 2, 6, 3,
                               6, 8,  3,  8, 9,  4, 9, 5, 2, 4, 11, 6,  2, 10, 8,  6, 7, 9, 8, 1};
  for (Vec3d& p : points) p.normalize();
  for (int level = 0; level < 4; ++level) {
    std::map<std::pair<int32_t, int32_t>, int32_t> middles;
    const auto middle = [&](int32_t a, int32_t b) {
      const auto [found, is_new] = middles.try_emplace(std::minmax(a, b), static_cast<int32_t>(points.size()));
      if (is_new) points.push_back((points[size_t(a)] + points[size_t(b)]).normalized());
      return found->second;
    };
    std::vector<int32_t> halved;
    for (size_t i = 0; i < corners.size(); i += 3) {
      const int32_t a = corners[i], b = corners[i + 1], c = corners[i + 2];
      const int32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      halved.insert(halved.end(), {a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca});
    }
    corners = std::move(halved);
  }
  double six_volumes = 0;
  for (size_t i = 0; i < corners.size(); i += 3)
    six_volumes += points[size_t(corners[i])].dot(points[size_t(corners[i + 1])].cross(points[size_t(corners[i + 2])]));
  const double scale = std::cbrt(8 * M_PI / six_volumes);
  std::vector<Vec3f> normals, scaled;
  for (const Vec3d& p : points) normals.emplace_back(p), scaled.emplace_back(p * scale);
  const size_t faces = corners.size() / 3;
  return {std::vector<int32_t>(faces, 3), std::move(corners), std::move(scaled), std::move(normals)};
}

support::InstancePoints arrays_of(Array<Vec3f> translations, const Array<Vec3f>& scales) {
  auto arrays = std::make_shared<support::InstanceArrays>();
  arrays->translations = std::move(translations), arrays->scales = scales;
  return arrays;
}

}  // namespace

std::map<Token, PulledPrimvar> take_values_by_point(PulledMesh* points, OtherPrimvars* others) {
  std::map<Token, PulledPrimvar> taken;
  const auto take = [&](const Token& name, PulledPrimvar* primvar) {
    if (!primvar->present) return;
    if (primvar->value.count() == 1 && primvar->indices.size() <= 1) primvar->interpolation = Interpolation::constant;
    if (primvar->interpolation != Interpolation::constant) taken[name] = std::exchange(*primvar, {});
  };
  take(kDisplayColor, &points->display_color), take(kDisplayOpacity, &points->display_opacity);
  for (auto* named : {&points->uvs, &others->by_name}) {
    for (auto& [name, primvar] : *named) take(name, &primvar);
    std::erase_if(*named, [](const auto& one) { return !one.second.present; });
  }
  return taken;
}

void make_sphere_of(PulledMesh* points) {
  static const Sphere sphere = make_sphere();
  points->widths = {}, points->tangents = {}, points->point_samples = {}, points->normal_samples = {};
  points->topology = {};
  points->topology.faceVertexCounts = sphere.counts, points->topology.faceVertexIndices = sphere.corners;
  points->points = {true, hd::Interpolation::vertex, sphere.points, {}};
  points->normals = {true, hd::Interpolation::vertex, sphere.normals, {}};
}

PlacedPoints place_points(const PulledMesh& pulled, const std::string& where, const alabaster::DiagnosticSink& sink) {
  PlacedPoints out;
  const auto warn = [&](const char* code, const std::string& text) {
    alabaster::report(sink, alabaster::Severity::warning, code, where, text);
  };
  const auto* points = pulled.points.value.get<Array<Vec3f>>();
  if (!points && !pulled.points.value.empty())
    warn("mesh.points.type", "points must be an array of three numbers each; nothing is drawn");
  const size_t count = points ? points->size() : 0;
  const auto* widths = pulled.widths.value.get<Array<float>>();
  const Array<int32_t>& indices = pulled.widths.indices;
  const size_t given = !widths ? 0 : indices.empty() ? widths->size() : indices.size();
  const bool indices_fit = std::all_of(indices.begin(), indices.end(), [&](int32_t i) {
    return i >= 0 && widths && static_cast<size_t>(i) < widths->size();
  });
  if (pulled.widths.present && !pulled.widths.value.empty() && ((given != 1 && given != count) || !indices_fit)) {
    warn("points.widths",
         "widths of points must be one number, or one for each of the " + std::to_string(count) + " points; 1 is used");
    widths = nullptr;
  }
  std::vector<Vec3f> scales;
  std::vector<int32_t> drawn;
  size_t unusable = 0;
  for (size_t i = 0; i < count; ++i) {
    const size_t of_point = given == 1 ? 0 : i;
    const float width = !widths ? 1 : (*widths)[indices.empty() ? of_point : static_cast<size_t>(indices[of_point])];
    const bool is_usable = is_finite((*points)[i]) && width >= 0 && std::isfinite(width);
    unusable += !is_usable;
    if (is_usable && width > 0) drawn.push_back(static_cast<int32_t>(i));
    scales.emplace_back(is_usable ? width / 2 : 0);
  }
  if (unusable > 0)
    warn("points.unusable", std::to_string(unusable) +
                                " points have no finite place, or a width that is negative or not finite; they are "
                                "not drawn");
  out.drawn = std::move(drawn);
  const Array<Vec3f> sizes(std::move(scales));
  out.points = arrays_of(points ? *points : Array<Vec3f>(), sizes);
  std::string fault = times_fault(pulled.point_samples.times, pulled.point_samples.values.size());
  for (const Value& sample : pulled.point_samples.values) {
    const auto* moved = sample.get<Array<Vec3f>>();
    if (!moved || moved->size() != count) fault = "the samples differ in their length from the points";
    if (fault.empty()) out.moving.values.push_back(arrays_of(*moved, sizes));
  }
  out.moving.times = pulled.point_samples.times;
  if (!fault.empty() && !pulled.point_samples.values.empty())
    warn("motion.points", "the samples of the points cannot be used: " + fault + "; they stand still");
  if (!fault.empty() || out.moving.values.size() < 2) out.moving = {};
  return out;
}

}  // namespace alabaster::hd::prims
