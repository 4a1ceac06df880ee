#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <stdexcept>
#include <tuple>

#include "delegate/hydra/captured_files.h"

namespace alabaster::hydra {
namespace {

using hd::Array;
using hd::Vec2f;
using hd::Vec3f;
using hd::host::InstancerDescription;
using hd::host::MeshDescription;
using nlohmann::json;

[[noreturn]] void refuse(const hd::Path& id, const std::string& why) {
  throw std::runtime_error(id.str() + " " + why);
}

/// A corner of a face: its point, and what else it carries. glTF has one vertex for all that are alike.
struct Corner {
  int32_t point = 0;
  Vec3f normal{0};
  Vec2f st{0};
  auto key() const { return std::tie(point, normal.x, normal.y, normal.z, st.x, st.y); }
  bool operator<(const Corner& o) const { return key() < o.key(); }
};

class GltfMeshes {
 public:
  void add(const hd::Path& id, const MeshDescription& mesh) {
    check(id, mesh);
    const bool has_normals = mesh.primvars.contains("normals"), has_st = mesh.primvars.contains("st");
    const std::vector<Vec3f> points = corners<Vec3f>(id, mesh, "points");
    const auto normals = has_normals ? corners<Vec3f>(id, mesh, "normals") : std::vector<Vec3f>();
    const auto st = has_st ? corners<Vec2f>(id, mesh, "st") : std::vector<Vec2f>();
    std::map<Corner, uint32_t> vertex_of;
    std::vector<uint32_t> indices;
    std::vector<Vec3f> vertex_points, vertex_normals;
    std::vector<Vec2f> vertex_st;
    for (const size_t i : triangle_corners(id, mesh, points)) {
      const Corner corner{mesh.topology.faceVertexIndices[i], has_normals ? normals[i] : Vec3f(0),
                          has_st ? Vec2f(st[i].x, 1 - st[i].y) : Vec2f(0)};  // glTF counts v downwards
      const auto [vertex, is_new] = vertex_of.emplace(corner, static_cast<uint32_t>(vertex_points.size()));
      indices.push_back(vertex->second);
      if (!is_new) continue;
      vertex_points.push_back(points[i]);
      if (has_normals) vertex_normals.push_back(corner.normal);
      if (has_st) vertex_st.push_back(corner.st);
    }
    json attributes = {{"POSITION", write(vertex_points, "VEC3", true)}};
    if (has_normals) attributes["NORMAL"] = write(vertex_normals, "VEC3", false);
    if (has_st) attributes["TEXCOORD_0"] = write(vertex_st, "VEC2", false);
    json primitive = {{"attributes", attributes}, {"indices", write(indices, "SCALAR", false)}};
    if (!mesh.material.empty()) primitive["material"] = material(PlainName(mesh.material), mesh.doubleSided);
    document_["meshes"].push_back({{"name", PlainName(id)}, {"primitives", {primitive}}});
  }

  void place(const hd::Path& id, size_t mesh, const hd::Matrix4d& matrix) {
    json node = {{"name", PlainName(id)}, {"mesh", mesh}};
    if (matrix != hd::Matrix4d()) node["matrix"] = std::vector<double>(&matrix.x[0][0], &matrix.x[0][0] + 16);
    document_["scenes"][0]["nodes"].push_back(document_["nodes"].size());
    document_["nodes"].push_back(std::move(node));
  }

  CapturedGltf finish(const std::string& buffer_name) {
    document_["asset"]["version"] = "2.0";
    document_["scene"] = 0;
    document_["buffers"] = {{{"uri", buffer_name}, {"byteLength", bytes_.size()}}};
    return {document_.dump(1), std::move(bytes_)};
  }

 private:
  static void check(const hd::Path& id, const MeshDescription& mesh) {
    if (!(mesh.topology.scheme == hd::Token("none"))) refuse(id, "is a cage for subdivision, which glTF cannot hold");
    if (!mesh.topology.geomSubsets.empty()) refuse(id, "has subsets, which are not written");
    if (!mesh.transformSamples.times.empty() || !mesh.primvarSamples.empty()) refuse(id, "moves, which is not written");
    if (mesh.material.empty() && mesh.doubleSided) refuse(id, "has two sides and no material, which glTF cannot hold");
    for (const char* name : {"subsurfaceSet", "holdout", "visibleToCamera"})
      if (mesh.primvars.contains(name)) refuse(id, std::string("has a primvar ") + name + ", which is not written");
    if (mesh.material.empty() && mesh.primvars.contains("displayColor"))
      refuse(id, "has no material but a colour of its own, which is not written");
    if (mesh.topology.orientation == hd::Token("leftHanded")) refuse(id, "is left-handed, which is not written");
    if (!mesh.topology.holeIndices.empty() || !mesh.topology.invisibleFaces.empty())
      refuse(id, "has faces that are not drawn, which is not written");
  }

  // The corners of triangles, by their numbers in the topology.
  static std::vector<size_t> triangle_corners(const hd::Path& id, const MeshDescription& mesh,
                                              const std::vector<Vec3f>& points) {
    std::vector<size_t> all;
    size_t first = 0;
    for (const int32_t count : mesh.topology.faceVertexCounts) {
      const auto corners = static_cast<size_t>(std::max(count, 0));
      if (corners < 3 || first + corners > points.size())
        refuse(id, "has faces of fewer than three corners, or too few indices");
      if (corners > 3 && !is_fan({points.data() + first, corners}))
        refuse(id, "has a face that is not convex, which is not written");
      for (size_t i = first + 1; i + 1 < first + corners; ++i) all.insert(all.end(), {first, i, i + 1});
      first += corners;
    }
    return all;
  }

  // True if the renderer cuts the polygon into a fan from its first corner (core/geometry/triangulation.h): along the
  // axis that is closest to its normal, all turns and all triangles of the fan go around the same way.
  static bool is_fan(std::span<const Vec3f> polygon) {
    const auto turn = [&](size_t a, size_t b, size_t c) {
      const hd::Vec3d from(polygon[a]);
      return (hd::Vec3d(polygon[b]) - from).cross(hd::Vec3d(polygon[c]) - from);
    };
    const size_t n = polygon.size();
    hd::Vec3d normal(0);
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

  // The value of each corner of a face.
  template <class T>
  static std::vector<T> corners(const hd::Path& id, const MeshDescription& mesh, const char* name) {
    const hd::host::PrimvarValue& primvar = mesh.primvars.at(name);
    const auto* values = primvar.value.get<Array<T>>();
    if (!values) refuse(id, std::string("has a primvar ") + name + " of another type, which is not written");
    const bool by_corner = primvar.interpolation == hd::Interpolation::faceVarying;
    if (primvar.interpolation == hd::Interpolation::uniform || primvar.interpolation == hd::Interpolation::constant)
      refuse(id, std::string("has ") + name + " by face or for all of it, which is not written");
    const Array<int32_t>& vertices = mesh.topology.faceVertexIndices;
    std::vector<T> all;
    for (size_t i = 0; i < vertices.size(); ++i) {
      size_t at = by_corner ? i : static_cast<size_t>(vertices[i]);
      if (!primvar.indices.empty()) {
        if (at >= primvar.indices.size()) refuse(id, std::string("has too few indices of ") + name);
        at = static_cast<size_t>(primvar.indices[at]);
      }
      if (at >= values->size()) refuse(id, std::string("has too few ") + name);
      all.push_back((*values)[at]);
    }
    return all;
  }

  template <class T>
  size_t write(const std::vector<T>& values, const char* type, bool bounded) {
    const size_t begin = bytes_.size(), length = values.size() * sizeof(T);
    bytes_.append(reinterpret_cast<const char*>(values.data()), length);
    document_["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", begin}, {"byteLength", length}});
    json accessor = {{"bufferView", document_["bufferViews"].size() - 1},
                     {"componentType", std::is_same_v<T, uint32_t> ? 5125 : 5126},
                     {"count", values.size()},
                     {"type", type}};
    if constexpr (std::is_same_v<T, Vec3f>)
      if (bounded) {
        Vec3f low(std::numeric_limits<float>::max()), high(std::numeric_limits<float>::lowest());
        for (const Vec3f& p : values)
          for (int i = 0; i < 3; ++i) low[i] = std::min(low[i], p[i]), high[i] = std::max(high[i], p[i]);
        accessor["min"] = {low.x, low.y, low.z}, accessor["max"] = {high.x, high.y, high.z};
      }
    document_["accessors"].push_back(std::move(accessor));
    return document_["accessors"].size() - 1;
  }

  // In glTF a material says whether its meshes have a back. Two of one name are both what the description matches.
  size_t material(const std::string& name, bool is_double_sided) {
    json& all = document_["materials"];
    for (size_t i = 0; i < all.size(); ++i)
      if (all[i]["name"] == name && all[i]["doubleSided"] == is_double_sided) return i;
    all.push_back({{"name", name}, {"doubleSided", is_double_sided}});
    return all.size() - 1;
  }

  json document_;
  std::string bytes_;
};

// Blender gives its instances as absolute matrices.
std::vector<hd::Matrix4d> places_of(const hd::Path& id, const MeshDescription& mesh,
                                    const std::map<hd::Path, InstancerDescription>& instancers) {
  if (mesh.instancer.empty()) return {mesh.transform};
  const auto found = instancers.find(mesh.instancer);
  if (found == instancers.end()) refuse(id, "has an instancer that was not synced");
  const InstancerDescription& instancer = found->second;
  const auto matrices = instancer.primvars.find("hydra:instanceTransforms");
  const auto* held = matrices == instancer.primvars.end() ? nullptr : matrices->second.get<Array<hd::Matrix4d>>();
  if (!held || !instancer.parent.empty())
    refuse(mesh.instancer, "does not place its instances by hydra:instanceTransforms alone; that is not written");
  std::vector<hd::Matrix4d> places;
  for (const int32_t index : instancer.indices.at(id))
    if (index >= 0 && static_cast<size_t>(index) < held->size())
      places.push_back(mesh.transform * (*held)[static_cast<size_t>(index)] * instancer.transform);
  return places;
}

}  // namespace

CapturedGltf MakeGltf(const std::map<hd::Path, MeshDescription>& meshes,
                      const std::map<hd::Path, InstancerDescription>& instancers, const std::string& buffer_name) {
  GltfMeshes gltf;
  size_t index = 0;
  for (const auto& [id, mesh] : meshes) {
    if (!mesh.visible || mesh.topology.faceVertexCounts.empty()) continue;
    gltf.add(id, mesh);
    for (const hd::Matrix4d& place : places_of(id, mesh, instancers)) gltf.place(id, index, place);
    ++index;
  }
  return gltf.finish(buffer_name);
}

}  // namespace alabaster::hydra
