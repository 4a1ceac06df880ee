#include "delegate/description/written_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <span>

#include "delegate/support/float_values.h"
#include "delegate/support/ngon_encoding.h"

namespace alabaster::hd::description {
namespace {

constexpr uint32_t kNone = ~0u;

[[noreturn]] void refuse(const Path& id, const std::string& why) {
  throw NotWritten(id, why);
}

void check_tags(const Path& id, const SubdivTags& tags) {
  if (!tags.creaseMethod.empty() && !(tags.creaseMethod == Token("uniform")))
    refuse(id, "has creaseMethod " + tags.creaseMethod.str() + ", which is not written");
  if (!tags.triangleSubdivision.empty() && !(tags.triangleSubdivision == Token("catmullClark")))
    refuse(id, "has triangleSubdivision " + tags.triangleSubdivision.str() + ", which is not written");
  if (tags.creaseWeights.size() != tags.creaseLengths.size())
    refuse(id, "has a sharpness for each edge of its creases, which is not written; give one for each crease");
}

void check(const Path& id, const host::MeshDescription& mesh) {
  const MeshTopology& topology = mesh.topology;
  for (const GeomSubset& subset : topology.geomSubsets)
    if (!subset.materialId.empty() && !subset.indices.empty())
      refuse(id, "has subsets with materials of their own, which is not written; give each a mesh");
  const auto moves = [](const auto& samples) { return samples.second.values.size() > 1; };
  if (std::any_of(mesh.primvarSamples.begin(), mesh.primvarSamples.end(), moves))
    refuse(id, "deforms, which is not written; set it without samples of its primvars");
  if (const auto points = mesh.primvars.find("points");
      points != mesh.primvars.end() && !points->second.indices.empty())
    refuse(id, "has indexed points, which is not written; let its faces name the points");
  if (topology.orientation == Token("leftHanded")) refuse(id, "is left-handed, which is not written");
  if (!topology.holeIndices.empty() || !topology.invisibleFaces.empty())
    refuse(id, "has faces that are not drawn, which is not written; leave them out of the mesh");
  if (!is_cage(mesh)) return;
  const Array<int32_t>& counts = topology.faceVertexCounts;
  if (topology.scheme == Token("loop") && std::any_of(counts.begin(), counts.end(), [](int32_t n) { return n != 3; }))
    refuse(id, "has scheme loop and faces that are no triangles, which is not written; cut them");
  check_tags(id, mesh.subdivTags);
  if (mesh.displayStyle.refineLevel == 0 && mesh.primvars.contains("normals"))
    refuse(id, "is a cage of refineLevel 0 with normals, which glTF cannot hold; refine it or set its scheme to none");
}

// True if the renderer cuts the polygon into a fan from its first corner (core/geometry/triangulation.h): along the
// axis that is closest to its normal, all turns and all triangles of the fan go around the same way.
bool is_fan(std::span<const Vec3f> polygon) {
  const auto turn = [&](size_t a, size_t b, size_t c) {
    const Vec3d from(polygon[a]);
    return (Vec3d(polygon[b]) - from).cross(Vec3d(polygon[c]) - from);
  };
  const size_t n = polygon.size();
  Vec3d normal(0);
  for (size_t i = 1; i + 1 < n; ++i) normal += turn(0, i, i + 1);
  int axis = 0;
  for (const int other : {1, 2})
    if (std::abs(normal[other]) > std::abs(normal[axis])) axis = other;
  const double side = normal[axis] < 0 ? -1 : 1;
  for (size_t i = 0; i < n; ++i)
    if (turn(i, (i + 1) % n, (i + 2) % n)[axis] * side < 0) return false;
  for (size_t i = 1; i + 1 < n; ++i)
    if (turn(0, i, i + 1)[axis] * side < 0) return false;
  return true;
}

// The corners of triangles, by their numbers in the topology. Polygons of cages need not be fans, as nobody draws
// their triangles.
std::vector<size_t> triangle_corners(const Path& id, const host::MeshDescription& mesh,
                                     const std::vector<Vec3f>& points) {
  std::vector<size_t> all;
  size_t first = 0;
  for (const int32_t count : mesh.topology.faceVertexCounts) {
    const auto corners = static_cast<size_t>(std::max(count, 0));
    if (corners < 3 || first + corners > points.size())
      refuse(id, "has faces of fewer than three corners, or too few indices");
    if (corners > 3 && !is_cage(mesh) && !is_fan({points.data() + first, corners}))
      refuse(id, "has a face that is not convex, which is not written; cut it into triangles");
    for (size_t i = first + 1; i + 1 < first + corners; ++i) all.insert(all.end(), {first, i, i + 1});
    first += corners;
  }
  return all;
}

// The value of each corner of a face.
template <class T>
std::vector<T> corner_values(const Path& id, const host::MeshDescription& mesh, const Token& name) {
  const auto found = mesh.primvars.find(name);
  if (found == mesh.primvars.end()) refuse(id, "has no primvar " + name.str());
  const host::PrimvarValue& primvar = found->second;
  const Value numbers = support::FloatValues(primvar.value);
  const auto* values = numbers.get<Array<T>>();
  if (!values) refuse(id, "has a primvar " + name.str() + " of another type, which is not written");
  // Faces name points, whatever their interpolation says.
  const Interpolation interpolation = name == Token("points") ? Interpolation::vertex : primvar.interpolation;
  const bool by_corner = interpolation == Interpolation::faceVarying;
  if (is_cage(mesh) && name != Token("points") && !by_corner)
    refuse(id, "is a cage with " + name.str() + " not by corner (faceVarying), which glTF cannot hold");
  if (interpolation == Interpolation::instance) refuse(id, "has " + name.str() + " by instance");
  std::vector<T> all;
  size_t face = 0, last = 0;  // the number of the first corner behind the face
  const MeshTopology& topology = mesh.topology;
  for (size_t i = 0; i < topology.faceVertexIndices.size(); ++i) {
    while (i >= last && face < topology.faceVertexCounts.size())
      last += static_cast<size_t>(std::max(topology.faceVertexCounts[face++], 0));
    size_t at = static_cast<size_t>(topology.faceVertexIndices[i]);
    if (by_corner) at = i;
    if (interpolation == Interpolation::constant) at = 0;
    if (interpolation == Interpolation::uniform) at = face - 1;
    if (!primvar.indices.empty()) {
      if (at >= primvar.indices.size()) refuse(id, "has too few indices of " + name.str());
      at = static_cast<size_t>(primvar.indices[at]);
    }
    if (at >= values->size()) refuse(id, "has too few " + name.str());
    all.push_back((*values)[at]);
  }
  return all;
}

// Readers of glTF normalize: a vector of almost unit length that they turn into `n`, if there is one near it.
Vec3f before_normalizing(const Vec3f& n) {
  constexpr float kAlmost = 1e-5f, kStep = 0x1p-20f;
  constexpr int kTries = 512;
  if (!(std::abs(n.length2() - 1) < kAlmost) || n.normalized() == n) return n;
  for (int i = 1; i <= kTries; ++i)
    for (const float scale : {1 + float(i) * kStep, 1 - float(i) * kStep})
      if (const Vec3f scaled = n * scale; scaled.normalized() == n) return scaled;
  return n;
}

/// Values that corners carry besides their points, as floats one after the other.
struct CornerData {
  size_t width = 0;
  bool has_normals = false, has_tangents = false, has_colors = false;
  std::vector<int> sets;  // of texture coordinates, in their order here
  std::vector<float> values;

  /// Adds `columns` values to each corner.
  template <class T>
  void add(const std::vector<T>& more) {
    constexpr size_t kColumns = T::dimensions();
    std::vector<float> wider;
    wider.reserve(more.size() * (width + kColumns));
    for (size_t i = 0; i < more.size(); ++i) {
      wider.insert(wider.end(), values.begin() + ptrdiff_t(i * width), values.begin() + ptrdiff_t((i + 1) * width));
      for (unsigned k = 0; k < kColumns; ++k) wider.push_back(more[i][int(k)]);
    }
    values = std::move(wider);
    width += kColumns;
  }
};

// The white of glTF where the mesh has opacities alone.
std::vector<Vec4f> own_colors(const Path& id, const host::MeshDescription& mesh, const OwnLook& look) {
  std::vector<Vec4f> all(mesh.topology.faceVertexIndices.size(), Vec4f(1));
  if (look.has_color) {
    const auto colors = corner_values<Vec3f>(id, mesh, "displayColor");
    for (size_t i = 0; i < all.size(); ++i) all[i] = Vec4f(colors[i].x, colors[i].y, colors[i].z, 1);
  }
  if (look.has_opacity) {
    const auto opacities = corner_values<float>(id, mesh, "displayOpacity");
    for (size_t i = 0; i < all.size(); ++i) all[i].w = opacities[i];
  }
  const auto is_held = [](const Vec4f& c) {
    return std::min({c.x, c.y, c.z, c.w}) >= 0 && std::max({c.x, c.y, c.z, c.w}) <= 1;
  };
  if (!std::all_of(all.begin(), all.end(), is_held))
    refuse(id, "has colours or opacities beyond 0 to 1, which glTF cannot hold; give it a material");
  return all;
}

CornerData read_corners(const Path& id, const host::MeshDescription& mesh, const UvSets& all_sets,
                        const OwnLook& look) {
  CornerData data;
  data.has_normals = !is_cage(mesh) && mesh.primvars.contains("normals");
  if (data.has_normals) {
    auto normals = corner_values<Vec3f>(id, mesh, "normals");
    for (Vec3f& n : normals) n = before_normalizing(n);
    data.add(normals);
  }
  data.has_tangents = data.has_normals && mesh.primvars.contains("tangents");
  if (data.has_tangents) data.add(corner_values<Vec4f>(id, mesh, "tangents"));
  data.has_colors = look.has_color || look.has_opacity;
  if (data.has_colors) data.add(own_colors(id, mesh, look));
  for (const Token& name : uv_names(mesh)) {
    auto st = corner_values<Vec2f>(id, mesh, name);
    for (Vec2f& one : st) one.y = 1 - one.y;
    data.add(st);
    data.sets.push_back(all_sets.at(name));
  }
  return data;
}

/// glTF's vertices: corners of one point that carry the same are one.
class Vertices {
 public:
  Vertices(size_t points, size_t width) : width_(width), first_(points, kNone) {}

  uint32_t find_or_add(size_t point, const float* values) {
    for (uint32_t v = first_[point]; v != kNone; v = next_[v])
      if (width_ == 0 || std::memcmp(&values_[v * width_], values, width_ * sizeof(float)) == 0) return v;
    const auto added = static_cast<uint32_t>(point_.size());
    point_.push_back(point);
    next_.push_back(first_[point]);
    values_.insert(values_.end(), values, values + width_);
    return first_[point] = added;
  }
  /// A vertex for each point that no face uses, so that points keep their numbers.
  void add_unused() {
    const std::vector<float> zeros(width_, 0.0f);
    for (size_t point = 0; point < first_.size(); ++point)
      if (first_[point] == kNone) find_or_add(point, zeros.data());
  }
  /// The vertices in the order of their points.
  std::vector<uint32_t> sorted() const {
    std::vector<uint32_t> order(point_.size());
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return point_[a] < point_[b]; });
    return order;
  }
  size_t point(uint32_t vertex) const { return point_[vertex]; }
  const float* values(uint32_t vertex) const { return &values_[vertex * width_]; }

 private:
  size_t width_;
  std::vector<uint32_t> first_, next_;  // of a point's vertices; of the next one of the same point
  std::vector<size_t> point_;
  std::vector<float> values_;
};

// True if corners of one point share values just where they did. Without indices the renderer makes equal values of a
// point one, as the reader does.
template <class T>
bool keeps_seams(const support::Cage& cage, const host::PrimvarValue& given, const std::vector<T>& written) {
  if (given.indices.empty()) return true;
  std::vector<float> numbers;
  for (const T& value : written)
    for (unsigned k = 0; k < T::dimensions(); ++k) numbers.push_back(value[int(k)]);
  const std::vector<int32_t> welded = support::weld_corners(cage, numbers, int(T::dimensions())).indices;
  std::map<std::pair<int32_t, int32_t>, int32_t> there, back;  // by point
  for (size_t i = 0; i < welded.size(); ++i) {
    const int32_t point = cage.face_vertex_indices[i];
    const int32_t own = given.indices[i];
    if (there.emplace(std::pair(point, own), welded[i]).first->second != welded[i]) return false;
    if (back.emplace(std::pair(point, welded[i]), own).first->second != own) return false;
  }
  return true;
}

template <class T>
bool is_same(const std::vector<T>& a, const Array<T>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end());
}

// Reads the cage as the reader of glTF will.
void check_cage(const Path& id, const host::MeshDescription& mesh, const UvSets& sets, size_t points,
                const TriangleList& list) {
  const support::Cage cage = support::build_cage(list.indices, list.points);
  if (cage.point_vertices.size() != points)
    refuse(id, "is a cage with two points at one place, which glTF would join; move them apart");
  if (!is_same(cage.face_vertex_counts, mesh.topology.faceVertexCounts) ||
      !is_same(cage.face_vertex_indices, mesh.topology.faceVertexIndices))
    refuse(id, "is a cage whose faces glTF would join or cut; let faces that follow each other begin at other points");
  const auto check_seams = [&](const Token& name, const auto& written) {
    if (!keeps_seams(cage, mesh.primvars.at(name), written))
      refuse(id,
             "has other seams of " + name.str() + " than its values show, which glTF cannot hold; leave out indices");
  };
  for (const Token& name : uv_names(mesh)) check_seams(name, list.uvs.at(sets.at(name)));
  for (const char* name : {"displayColor", "displayOpacity"})
    if (!list.colors.empty() && mesh.primvars.contains(name)) check_seams(name, list.colors);
}

}  // namespace

std::vector<Token> uv_names(const host::MeshDescription& mesh) {
  std::vector<Token> names;
  for (const auto& [name, primvar] : mesh.primvars)
    if (name == Token("st") || primvar.role == Token("textureCoordinate")) names.push_back(name);
  return names;
}

bool is_cage(const host::MeshDescription& mesh) {
  const std::string& scheme = mesh.topology.scheme.str();
  return scheme == "catmullClark" || scheme == "loop" || scheme == "bilinear";
}

bool is_double_sided(const Path& id, const host::MeshDescription& mesh) {
  const bool hides = mesh.cullStyle == CullStyle::back || mesh.cullStyle == CullStyle::front ||
                     (mesh.cullStyle == CullStyle::frontUnlessDoubleSided && !mesh.doubleSided);
  if (hides) refuse(id, "hides sides from the camera alone by its cull style, which is not written");
  return mesh.doubleSided || mesh.cullStyle == CullStyle::nothing;
}

OwnLook own_look(const host::MeshDescription& mesh) {
  const auto has = [&](const char* name) {
    const auto found = mesh.primvars.find(name);
    return found != mesh.primvars.end() && !found->second.value.empty();
  };
  return {has("displayColor"), has("displayOpacity")};
}

TriangleList triangles_of(const Path& id, const host::MeshDescription& mesh, const UvSets& sets, const OwnLook& look) {
  check(id, mesh);
  const std::vector<Vec3f> points = corner_values<Vec3f>(id, mesh, "points");
  const Array<int32_t>& corner_points = mesh.topology.faceVertexIndices;
  const Value numbers = support::FloatValues(mesh.primvars.at("points").value);
  const auto& all_points = *numbers.get<Array<Vec3f>>();
  const auto is_finite = [](const Vec3f& p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); };
  if (!std::all_of(all_points.begin(), all_points.end(), is_finite))
    refuse(id, "has points that are not finite, which glTF cannot hold; mend them");
  const CornerData data = read_corners(id, mesh, sets, look);
  Vertices vertices(all_points.size(), data.width);
  TriangleList list;
  for (const size_t i : triangle_corners(id, mesh, points))
    list.indices.push_back(
        vertices.find_or_add(static_cast<size_t>(corner_points[i]), data.values.data() + i * data.width));
  list.is_cage = is_cage(mesh);
  if (list.is_cage) vertices.add_unused();
  const std::vector<uint32_t> order = vertices.sorted();
  std::vector<uint32_t> place(order.size());
  for (uint32_t i = 0; i < order.size(); ++i) {
    place[order[i]] = i;
    list.points.push_back(all_points[vertices.point(order[i])]);
    const float* values = data.width == 0 ? nullptr : vertices.values(order[i]);
    if (data.has_normals) list.normals.emplace_back(values[0], values[1], values[2]), values += 3;
    if (data.has_tangents) list.tangents.emplace_back(values[0], values[1], values[2], values[3]), values += 4;
    if (data.has_colors) list.colors.emplace_back(values[0], values[1], values[2], values[3]), values += 4;
    for (const int set : data.sets) list.uvs[set].emplace_back(values[0], values[1]), values += 2;
  }
  for (uint32_t& index : list.indices) index = place[index];
  if (list.is_cage) check_cage(id, mesh, sets, all_points.size(), list);
  return list;
}

}  // namespace alabaster::hd::description
