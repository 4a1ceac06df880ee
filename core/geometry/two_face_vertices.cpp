#include "core/geometry/two_face_vertices.h"

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "core/geometry/index.h"

namespace alabaster {
namespace {

namespace Far = OpenSubdiv::Far;

// The face across an edge; -1: none, or several.
int across(const Far::TopologyLevel& base, int edge, int face) {
  const auto faces = base.GetEdgeFaces(edge);
  return faces.size() != 2 ? -1 : faces[0] == face ? faces[1] : faces[0];
}

void leave_out_creases(const Far::TopologyLevel& base, Cage* cage, std::string* message) {
  std::vector<bool> near(cage->points.size(), false);
  for (int face = 0; face < base.GetNumFaces(); ++face)
    if (has_two_face_vertex(base, face))
      for (const int vertex : base.GetFaceVertices(face)) near[at(vertex)] = true;
  const std::vector<int> ends = std::exchange(cage->crease_indices, {});
  const std::vector<float> sharpnesses = std::exchange(cage->crease_sharpnesses, {});
  std::string first;
  for (size_t i = 0; i < sharpnesses.size(); ++i) {  // single edges in a sanitized cage
    const int a = ends[2 * i], b = ends[2 * i + 1];
    if (!near[at(a)] && !near[at(b)]) {
      cage->crease_indices.insert(cage->crease_indices.end(), {a, b});
      cage->crease_sharpnesses.push_back(sharpnesses[i]);
    } else if (first.empty()) {
      first = std::to_string(a) + " to " + std::to_string(b);
    }
  }
  cage->crease_lengths.assign(cage->crease_sharpnesses.size(), 2);
  if (const size_t left_out = sharpnesses.size() - cage->crease_sharpnesses.size())
    *message = std::to_string(left_out) + " edges lose their crease, the first from point " + first +
               ", because a face there has a vertex that only one other face shares: dissolve that vertex to keep them";
}

// Corners of one point with one index share a value, which is that of the first of them.
template <class T>
void separate_points(const std::vector<int>& points, Primvar<T>* primvar) {
  if (primvar->interpolation != Interpolation::face_varying || primvar->indices.empty()) return;
  std::map<std::pair<int, int>, int> firsts;
  std::vector<T> values;
  values.reserve(points.size());
  for (size_t corner = 0; corner < points.size(); ++corner) {
    int& index = primvar->indices[corner];
    values.push_back(primvar->values[at(index)]);
    index = firsts.emplace(std::pair(points[corner], index), static_cast<int>(corner)).first->second;
  }
  primvar->values = std::move(values);
}

}  // namespace

bool has_two_face_vertex(const Far::TopologyLevel& base, int face) {
  const auto edges = base.GetFaceEdges(face);
  int last = across(base, edges[edges.size() - 1], face);
  for (const int edge : edges) {
    const int next = across(base, edge, face);
    if (next >= 0 && next == last) return true;
    last = next;
  }
  return false;
}

bool any_has_two_face_vertex(const Far::TopologyLevel& base) {
  for (int face = 0; face < base.GetNumFaces(); ++face)
    if (has_two_face_vertex(base, face)) return true;
  return false;
}

bool is_sharp_at_two_face_vertex(const Far::TopologyLevel& base) {
  const auto is_sharp = [&](int edge) { return base.GetEdgeSharpness(edge) > 0 && base.GetEdgeFaces(edge).size() > 1; };
  for (int face = 0; face < base.GetNumFaces(); ++face) {
    if (!has_two_face_vertex(base, face)) continue;
    for (const int vertex : base.GetFaceVertices(face)) {
      const auto edges = base.GetVertexEdges(vertex);
      if (std::any_of(edges.begin(), edges.end(), is_sharp)) return true;
    }
  }
  return false;
}

Cage cage_for_two_face_vertices(const Cage& cage, const Far::TopologyLevel& base, std::string* message) {
  Cage safe = cage;
  if (is_sharp_at_two_face_vertex(base)) leave_out_creases(base, &safe, message);
  for_each_refined(safe, [&](auto& primvar) { separate_points(safe.face_vertex_indices, &primvar); });
  return safe;
}

}  // namespace alabaster
