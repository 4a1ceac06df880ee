#include "delegate/gltf/gltf_mesh.h"

#include <cmath>
#include <numeric>

#include "delegate/gltf/gltf_material.h"
#include "delegate/gltf/gltf_ngon.h"

namespace alabaster::hd::gltf {
namespace {

template <class V>
std::vector<V> read_vectors(const AccessorView& accessor) {
  const std::vector<float> values = read_floats(accessor);
  std::vector<V> vectors(accessor.count);
  for (size_t i = 0; i < accessor.count; ++i)
    for (unsigned c = 0; c < V::dimensions(); ++c) vectors[i][int(c)] = values[i * accessor.components + c];
  return vectors;
}

const AccessorView* find_attribute(const Document& document, const tinygltf::Primitive& primitive,
                                   const std::string& name) {
  const auto found = primitive.attributes.find(name);
  return found == primitive.attributes.end() ? nullptr : &document.accessors[size_t(found->second)];
}

// KHR_texture_transform: uv' = translation * rotation * scale * uv, in glTF's coordinates (v down).
struct TextureTransform {
  double offset[2] = {0, 0}, scale[2] = {1, 1}, rotation = 0;
  Vec2f apply(const Vec2f& uv) const {
    const double x = double(uv.x) * scale[0], y = double(uv.y) * scale[1];
    const double c = std::cos(rotation), s = std::sin(rotation);
    return {float(c * x + s * y + offset[0]), float(-s * x + c * y + offset[1])};
  }
};

double number_at(const tinygltf::Value& value, const char* name, int index, double fallback) {
  if (!value.Has(name)) return fallback;
  const tinygltf::Value& found = value.Get(name);
  return found.IsArray() ? found.Get(index).GetNumberAsDouble() : found.GetNumberAsDouble();
}

std::vector<Vec2f> read_st(const Document& document, const tinygltf::Primitive& primitive) {
  int set = 0;
  TextureTransform transform;
  if (primitive.material >= 0) {
    const TextureUses textures = textures_of(document.model.materials[size_t(primitive.material)]);
    const TextureUse& use = textures.of_coordinates();
    set = use.coordinates;
    if (use.transform) {
      set = int(number_at(*use.transform, "texCoord", 0, set));
      for (int i = 0; i < 2; ++i) {
        transform.offset[i] = number_at(*use.transform, "offset", i, 0);
        transform.scale[i] = number_at(*use.transform, "scale", i, 1);
      }
      transform.rotation = number_at(*use.transform, "rotation", 0, 0);
    }
  }
  const AccessorView* accessor = find_attribute(document, primitive, "TEXCOORD_" + std::to_string(set));
  if (!accessor) return {};
  std::vector<Vec2f> st = read_vectors<Vec2f>(*accessor);
  for (Vec2f& uv : st) {
    uv = transform.apply(uv);
    uv.y = 1 - uv.y;
  }
  return st;
}

std::vector<Vec3f> read_normals(const AccessorView& accessor) {
  std::vector<Vec3f> normals = read_vectors<Vec3f>(accessor);
  for (Vec3f& n : normals) n = std::isfinite(n.length2()) ? n.normalized() : Vec3f(0);
  return normals;
}

std::vector<int32_t> to_signed(const std::vector<uint32_t>& values) {
  return {values.begin(), values.end()};
}

void set_cage(const std::vector<uint32_t>& triangles, const std::vector<Vec3f>& points, const std::vector<Vec2f>& st,
              host::MeshDescription* mesh, size_t* dropped_faces) {
  Cage cage = build_cage(triangles, points, st);
  *dropped_faces = cage.dropped_faces;
  mesh->topology.scheme = "catmullClark";
  mesh->topology.faceVertexCounts = std::move(cage.face_vertex_counts);
  mesh->topology.faceVertexIndices = std::move(cage.face_vertex_indices);
  mesh->primvars["points"] = {Interpolation::vertex, "point", Array<Vec3f>(std::move(cage.points)), {}};
  if (!st.empty())
    mesh->primvars["st"] = {Interpolation::faceVarying, "textureCoordinate", Array<Vec2f>(std::move(cage.st)),
                            Array<int32_t>(std::move(cage.st_indices))};
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
                                                         const std::string& element, int refine_level, Report& report) {
  const int mode = primitive.mode < 0 ? TINYGLTF_MODE_TRIANGLES : primitive.mode;
  if (mode < TINYGLTF_MODE_TRIANGLES) {
    report.warning("mesh.mode", element + ".mode", "points and lines are not drawn; use triangles");
    return {};
  }
  const AccessorView* positions = find_attribute(document, primitive, "POSITION");
  if (!positions) return {};  // reported by check_meshes
  std::vector<uint32_t> indices(positions->count);
  std::iota(indices.begin(), indices.end(), 0u);
  if (primitive.indices >= 0) indices = read_indices(document.accessors[size_t(primitive.indices)]);
  const std::vector<uint32_t> triangles = triangle_list(indices, mode);
  if (triangles.empty()) return {};  // reported by check_meshes

  host::MeshDescription mesh;
  std::vector<Vec3f> points = read_vectors<Vec3f>(*positions);
  std::vector<Vec2f> st = read_st(document, primitive);
  if (primitive.attributes.count("COLOR_0"))
    report.warning("mesh.color", element + ".attributes.COLOR_0", "vertex colours are not supported and are ignored");
  if (primitive.material >= 0)
    mesh.doubleSided = document.model.materials[size_t(primitive.material)].doubleSided;
  else
    mesh.doubleSided = false;
  if (primitive.extensions.count("FB_ngon_encoding") && mode == TINYGLTF_MODE_TRIANGLES) {
    size_t dropped_faces = 0;
    set_cage(triangles, points, st, &mesh, &dropped_faces);
    mesh.displayStyle.refineLevel = refine_level;
    if (dropped_faces > 0)
      report.warning("mesh.degenerate", element,
                     std::to_string(dropped_faces) + " faces have no area and are left out");
    if (mesh.topology.faceVertexCounts.empty()) return {};
    return mesh;
  }
  mesh.topology.faceVertexCounts = std::vector<int32_t>(triangles.size() / 3, 3);
  mesh.topology.faceVertexIndices = to_signed(triangles);
  mesh.primvars["points"] = {Interpolation::vertex, "point", Array<Vec3f>(std::move(points)), {}};
  if (const AccessorView* normals = find_attribute(document, primitive, "NORMAL"))
    mesh.primvars["normals"] = {Interpolation::vertex, "normal", Array<Vec3f>(read_normals(*normals)), {}};
  if (!st.empty()) mesh.primvars["st"] = {Interpolation::vertex, "textureCoordinate", Array<Vec2f>(std::move(st)), {}};
  return mesh;
}

}  // namespace alabaster::hd::gltf
