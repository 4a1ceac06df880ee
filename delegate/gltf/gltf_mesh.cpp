#include "delegate/gltf/gltf_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>

#include "delegate/gltf/gltf_material.h"
#include "delegate/gltf/gltf_ngon_encoding.h"
#include "delegate/gltf/gltf_vertices.h"

namespace alabaster::hd::gltf {
namespace {

// The first components of each element.
template <class V>
std::vector<V> to_vectors(const VertexAttribute& attribute) {
  std::vector<V> vectors(attribute.values.empty() ? 0 : attribute.values.size() / attribute.components);
  for (size_t i = 0; i < vectors.size(); ++i)
    for (unsigned c = 0; c < V::dimensions(); ++c) vectors[i][int(c)] = attribute.values[i * attribute.components + c];
  return vectors;
}

Value to_array(const VertexAttribute& attribute) {
  switch (attribute.components) {
    case 1:
      return Array<float>(attribute.values);
    case 2:
      return Array<Vec2f>(to_vectors<Vec2f>(attribute));
    case 3:
      return Array<Vec3f>(to_vectors<Vec3f>(attribute));
    default:
      return Array<Vec4f>(to_vectors<Vec4f>(attribute));
  }
}

struct Primvar {
  std::string name, role;
  VertexAttribute attribute;
};

// Texture coordinates and colours.
std::vector<Primvar> read_primvars(const VertexReader& reader) {
  std::vector<Primvar> primvars;
  constexpr std::string_view kSet = "TEXCOORD_";
  for (const auto& [name, index] : reader.primitive.attributes) {  // the sets may have gaps, though glTF allows none
    if (!name.starts_with(kSet) || name.size() > kSet.size() + 3) continue;
    const int set = std::atoi(name.c_str() + kSet.size());
    if (set < 0 || name != std::string(kSet) + std::to_string(set)) continue;
    VertexAttribute st = reader.read(name);
    for (size_t i = 1; i < st.values.size(); i += 2) st.values[i] = 1 - st.values[i];
    primvars.push_back({uv_set_name(set), "textureCoordinate", std::move(st)});
  }
  const VertexAttribute colors = reader.read("COLOR_0");
  VertexAttribute rgb{{}, 3}, opacity{{}, 1};
  for (size_t i = 0; i < colors.values.size(); ++i)
    (i % colors.components < 3 ? rgb : opacity).values.push_back(std::clamp(colors.values[i], 0.0f, 1.0f));
  if (!rgb.values.empty()) primvars.push_back({"displayColor", "color", std::move(rgb)});
  if (!opacity.values.empty()) primvars.push_back({"displayOpacity", "", std::move(opacity)});
  return primvars;
}

SkinnedVertices read_vertices(const VertexReader& reader, const std::vector<Matrix4d>& joint_matrices) {
  SkinnedVertices vertices;
  vertices.points = to_vectors<Vec3f>(reader.read("POSITION"));
  vertices.normals = to_vectors<Vec3f>(reader.read("NORMAL"));
  if (!vertices.normals.empty()) vertices.tangents = to_vectors<Vec4f>(reader.read("TANGENT"));
  if (!joint_matrices.empty() && follows_skin(reader.primitive)) skin_vertices(reader, joint_matrices, &vertices);
  for (Vec3f& n : vertices.normals) n = std::isfinite(n.length2()) ? n.normalized() : Vec3f(0);
  return vertices;
}

// The vertices that the triangles use, which then refer to these; empty if they use all `count` of them.
std::vector<uint32_t> take_used(size_t count, std::vector<uint32_t>* triangles) {
  std::vector<uint32_t> used;
  if (triangles->size() < count) {  // many primitives may share a large array
    used = *triangles;
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
  } else {
    std::vector<char> is_used(count, 0);
    for (const uint32_t vertex : *triangles) is_used[vertex] = 1;
    if (std::find(is_used.begin(), is_used.end(), 0) == is_used.end()) return {};
    for (uint32_t v = 0; v < count; ++v)
      if (is_used[v]) used.push_back(v);
  }
  for (uint32_t& vertex : *triangles)
    vertex = uint32_t(std::lower_bound(used.begin(), used.end(), vertex) - used.begin());
  return used;
}

// The polygons and seams are those of the mesh at rest, so that no pose changes them.
struct CageSource {
  const std::vector<Vec3f>&rest, &points;
  const std::vector<uint32_t>& triangles;
};
bool set_cage(const CageSource& source, const std::vector<Primvar>& primvars, const std::string& element,
              Report& report, host::MeshDescription* mesh) {
  Cage cage = build_cage(source.triangles, source.rest);
  if (cage.dropped_faces > 0)
    report.warning("mesh.degenerate", element,
                   std::to_string(cage.dropped_faces) + " faces have no area and are left out");
  std::vector<Vec3f> welded;
  for (const uint32_t vertex : cage.point_vertices) welded.push_back(source.points[vertex]);
  mesh->primvars["points"] = {Interpolation::vertex, "point", Array<Vec3f>(std::move(welded)), {}};
  for (const Primvar& primvar : primvars) {
    const size_t n = primvar.attribute.components;
    CornerValues corners = weld_corners(cage, primvar.attribute.values, n);
    VertexAttribute values{{}, n};
    for (const uint32_t vertex : corners.vertices)
      for (size_t c = 0; c < n; ++c) values.values.push_back(primvar.attribute.values[vertex * n + c]);
    mesh->primvars[primvar.name] = {Interpolation::faceVarying, primvar.role, to_array(values),
                                    Array<int32_t>(std::move(corners.indices))};
  }
  mesh->topology.scheme = "catmullClark";
  mesh->topology.faceVertexCounts = std::move(cage.face_vertex_counts);
  mesh->topology.faceVertexIndices = std::move(cage.face_vertex_indices);
  return !mesh->topology.faceVertexCounts.empty();
}

void set_triangles(SkinnedVertices vertices, const std::vector<Primvar>& primvars,
                   const std::vector<uint32_t>& triangles, host::MeshDescription* mesh) {
  mesh->topology.faceVertexCounts = std::vector<int32_t>(triangles.size() / 3, 3);
  mesh->topology.faceVertexIndices = std::vector<int32_t>(triangles.begin(), triangles.end());
  mesh->primvars["points"] = {Interpolation::vertex, "point", Array<Vec3f>(std::move(vertices.points)), {}};
  if (!vertices.normals.empty())
    mesh->primvars["normals"] = {Interpolation::vertex, "normal", Array<Vec3f>(std::move(vertices.normals)), {}};
  if (!vertices.tangents.empty())
    mesh->primvars["tangents"] = {Interpolation::vertex, "vector", Array<Vec4f>(std::move(vertices.tangents)), {}};
  for (const Primvar& primvar : primvars)
    mesh->primvars[primvar.name] = {Interpolation::vertex, primvar.role, to_array(primvar.attribute), {}};
}

}  // namespace

std::vector<uint32_t> triangle_list(const std::vector<uint32_t>& indices, int mode) {
  const size_t n = indices.size();
  if (mode == TINYGLTF_MODE_TRIANGLES) return {indices.begin(), indices.begin() + std::ptrdiff_t(n / 3 * 3)};
  std::vector<uint32_t> triangles;
  if (n < 3) return triangles;
  triangles.reserve((n - 2) * 3);
  for (size_t i = 0; i + 2 < n; ++i) {
    if (mode == TINYGLTF_MODE_TRIANGLE_STRIP) {  // p_i = {v_i, v_(i+1+i%2), v_(i+2-i%2)}
      triangles.insert(triangles.end(), {indices[i], indices[i + 1 + i % 2], indices[i + 2 - i % 2]});
    } else {  // p_i = {v_(i+1), v_(i+2), v_0}
      triangles.insert(triangles.end(), {indices[i + 1], indices[i + 2], indices[0]});
    }
  }
  return triangles;
}

std::optional<host::MeshDescription> translate_primitive(const Document& document, const tinygltf::Primitive& primitive,
                                                         const std::string& element, const PrimitiveShape& shape,
                                                         Report& report) {
  const int mode = primitive.mode < 0 ? TINYGLTF_MODE_TRIANGLES : primitive.mode;
  if (mode < TINYGLTF_MODE_TRIANGLES) {
    report.warning("mesh.mode", element + ".mode", "points and lines are not drawn; use triangles");
    return {};
  }
  const auto positions = primitive.attributes.find("POSITION");
  if (positions == primitive.attributes.end()) return {};  // reported by check_meshes
  const size_t count = document.accessors[size_t(positions->second)].count;
  std::vector<uint32_t> indices(count);
  std::iota(indices.begin(), indices.end(), 0u);
  if (primitive.indices >= 0) indices = read_indices(document.accessors[size_t(primitive.indices)]);
  std::vector<uint32_t> triangles = triangle_list(indices, mode);
  if (triangles.empty()) return {};  // reported by check_meshes

  const VertexReader reader{document, primitive, take_used(count, &triangles), shape.weights};
  host::MeshDescription mesh;
  SkinnedVertices vertices = read_vertices(reader, shape.joint_matrices);
  const std::vector<Primvar> primvars = read_primvars(reader);
  mesh.doubleSided =
      primitive.material >= 0 && document.materials[size_t(primitive.material)].value("doubleSided", false);
  if (vertices.mirrored) mesh.topology.orientation = "leftHanded";
  if (primitive.extensions.contains("FB_ngon_encoding") && mode == TINYGLTF_MODE_TRIANGLES) {
    const auto rest = to_vectors<Vec3f>(reader.read_at_rest("POSITION"));
    mesh.displayStyle.refineLevel = shape.refine_level;
    if (!set_cage({rest, vertices.points, triangles}, primvars, element, report, &mesh)) return {};
    return mesh;
  }
  set_triangles(std::move(vertices), primvars, triangles, &mesh);
  return mesh;
}

}  // namespace alabaster::hd::gltf
