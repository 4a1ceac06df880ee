#include "delegate/gltf/gltf_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <numeric>

#include "core/material/disney_parameters.h"
#include "delegate/gltf/gltf_material.h"
#include "delegate/gltf/gltf_ngon_encoding.h"
#include "delegate/gltf/gltf_scene.h"
#include "delegate/gltf/gltf_surfaces.h"
#include "delegate/gltf/gltf_vertices.h"
#include "delegate/support/color_space.h"

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
  if (!rgb.values.empty()) primvars.push_back({"displayColor", support::kLinearRec709, std::move(rgb)});
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

bool is_cage(const tinygltf::Primitive& primitive) {
  return primitive.extensions.contains("FB_ngon_encoding") &&
         (primitive.mode < 0 || primitive.mode == TINYGLTF_MODE_TRIANGLES);
}

template <class T>
void append(std::vector<T>&& more, std::vector<T>* all) {
  if (all->empty())
    *all = std::move(more);
  else
    all->insert(all->end(), more.begin(), more.end());
}

template <class T>
std::vector<T> gathered(const T* values, const std::vector<uint32_t>& places, size_t components = 1) {
  std::vector<T> taken;
  taken.reserve(places.size() * components);
  for (const uint32_t place : places)
    for (size_t c = 0; c < components; ++c) taken.push_back(values[place * components + c]);
  return taken;
}

// A primitive as it is read.
struct Piece {
  size_t primitive;
  VertexReader reader;
  SkinnedVertices vertices;
  std::vector<uint32_t> triangles;
  std::string key;
  std::vector<Primvar> primvars = {};  // of its vertices, where it is added to a surface

  // Gives each triangle vertices of its own, whose normals are the triangle's: it has no NORMAL, others have.
  void flatten() {
    vertices.points = gathered(vertices.points.data(), triangles);
    for (Primvar& primvar : primvars)
      primvar.attribute.values = gathered(primvar.attribute.values.data(), triangles, primvar.attribute.components);
    std::iota(triangles.begin(), triangles.end(), 0u);
    for (size_t i = 0; i < triangles.size(); i += 3) {
      const Vec3f* const p = &vertices.points[i];
      Vec3f normal = (p[1] - p[0]).cross(p[2] - p[0]).normalized();
      if (!(normal.length2() > 0)) normal = Vec3f(0, 0, 1);  // a triangle without area shows none
      vertices.normals.insert(vertices.normals.end(), 3, vertices.mirrored ? -normal : normal);
    }
  }
};

// The triangles of one primitive or more.
struct Surface {
  SkinnedVertices vertices;
  std::vector<Vec3f> rest;  // the points at rest, of cages
  std::vector<Primvar> primvars;
  std::vector<uint32_t> triangles;
  std::vector<size_t> ends;  // of the primitives, in `triangles`
  struct Points {
    size_t end;       // of a primitive, in the points
    float own_color;  // of its material, where it has no COLOR_0
  };
  std::vector<Points> points;
  bool has_normals = false;  // some primitive has
  bool has_tangents = true;  // all primitives have

  void add(Piece piece) {
    const auto first = uint32_t(vertices.points.size());
    piece.primvars = read_primvars(piece.reader);
    if (is_cage(piece.reader.primitive))
      append(to_vectors<Vec3f>(piece.reader.read_at_rest("POSITION")), &rest);
    else if (has_normals && piece.vertices.normals.empty())
      piece.flatten();
    const size_t count = first + piece.vertices.points.size();
    vertices.mirrored = piece.vertices.mirrored;
    append(std::move(piece.vertices.points), &vertices.points);
    append(std::move(piece.vertices.normals), &vertices.normals);
    if (has_tangents) append(std::move(piece.vertices.tangents), &vertices.tangents);
    points.push_back({count, piece.reader.primitive.material < 0 ? DisneyParameters().base_color.r : 1});
    // Without texture coordinates they are 0, and without colours a material has its own.
    const auto fill = [&](Primvar* primvar, size_t pieces) {
      for (const Points& of : std::span(points).first(pieces))
        primvar->attribute.values.resize(
            std::max(primvar->attribute.values.size(), of.end * primvar->attribute.components),
            primvar->role == "textureCoordinate" ? 0
            : primvar->name == "displayColor"    ? of.own_color
                                                 : 1);
    };
    for (Primvar& more : piece.primvars) {
      const auto same = [&](const Primvar& known) { return known.name == more.name; };
      auto known = std::find_if(primvars.begin(), primvars.end(), same);
      if (known == primvars.end()) {
        known = primvars.insert(known, {more.name, more.role, {{}, more.attribute.components}});
        fill(&*known, points.size() - 1);
      }
      append(std::move(more.attribute.values), &known->attribute.values);
    }
    for (Primvar& primvar : primvars) fill(&primvar, points.size());
    for (uint32_t& corner : piece.triangles) corner += first;
    append(std::move(piece.triangles), &triangles);
    ends.push_back(triangles.size());
  }
};

// The polygons and seams are those of the mesh at rest, so that no pose changes them.
void set_cage(const Surface& surface, Cage cage, host::MeshDescription* mesh) {
  std::vector<Vec3f> welded;
  for (const uint32_t vertex : cage.point_vertices) welded.push_back(surface.vertices.points[vertex]);
  mesh->primvars["points"] = {Interpolation::vertex, "point", Array<Vec3f>(std::move(welded)), {}};
  for (const Primvar& primvar : surface.primvars) {
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
}

void set_triangles(Surface surface, host::MeshDescription* mesh) {
  const std::vector<uint32_t>& triangles = surface.triangles;
  SkinnedVertices& vertices = surface.vertices;
  mesh->topology.faceVertexCounts = std::vector<int32_t>(triangles.size() / 3, 3);
  mesh->topology.faceVertexIndices = std::vector<int32_t>(triangles.begin(), triangles.end());
  mesh->primvars["points"] = {Interpolation::vertex, "point", Array<Vec3f>(std::move(vertices.points)), {}};
  if (!vertices.normals.empty())
    mesh->primvars["normals"] = {Interpolation::vertex, "normal", Array<Vec3f>(std::move(vertices.normals)), {}};
  if (!vertices.tangents.empty())
    mesh->primvars["tangents"] = {Interpolation::vertex, "vector", Array<Vec4f>(std::move(vertices.tangents)), {}};
  for (const Primvar& primvar : surface.primvars)
    mesh->primvars[primvar.name] = {Interpolation::vertex, primvar.role, to_array(primvar.attribute), {}};
}

std::vector<float> floats_of(const Value& value) {
  std::vector<float> floats(value.count() * GetTypeInfo(value.type()).components);
  for (size_t i = 0; i < floats.size(); ++i) floats[i] = float(value.component(i));
  return floats;
}

void gather_samples(const std::vector<uint32_t>& vertices, TimeSamples<Value>* samples) {
  for (Value& sample : samples->values)
    if (const auto* held = sample.get<Array<Vec3f>>()) sample = Array<Vec3f>(gathered(held->data(), vertices));
}

std::vector<int32_t> points_of(const Array<int32_t>& vertices, const std::vector<int32_t>& points) {
  std::vector<int32_t> moved(vertices.begin(), vertices.end());
  for (int32_t& vertex : moved) vertex = points[size_t(vertex)];  // it was checked when it was set
  return moved;
}

}  // namespace

size_t WeldVertices(host::MeshDescription* mesh) {
  MeshTopology& topology = mesh->topology;
  Surface surface;
  const auto* points = mesh->primvars["points"].value.get<Array<Vec3f>>();
  const auto is_triangle = [](int32_t count) { return count == 3; };
  if (!points || topology.faceVertexIndices.empty() ||
      !std::all_of(topology.faceVertexCounts.begin(), topology.faceVertexCounts.end(), is_triangle))
    return 0;
  surface.vertices.points.assign(points->begin(), points->end());
  surface.triangles.assign(topology.faceVertexIndices.begin(), topology.faceVertexIndices.end());
  for (size_t end = 3; end <= surface.triangles.size(); end += 3) surface.ends.push_back(end);  // no polygons
  Cage cage = build_cage(surface.triangles, surface.vertices.points, surface.ends);
  mesh->primvars.erase("tangents"), mesh->primvarSamples.erase("tangents");
  for (const auto& [name, primvar] : mesh->primvars)
    if (primvar.interpolation == Interpolation::vertex && !(name == Token("points")))
      surface.primvars.push_back(
          {name.str(), primvar.role.str(), {floats_of(primvar.value), GetTypeInfo(primvar.value.type()).components}});
  for (auto& [name, samples] : mesh->primvarSamples)
    gather_samples(name == Token("points") ? cage.point_vertices
                                           : weld_corners(cage, floats_of(mesh->primvars[name].value), 3).vertices,
                   &samples);
  std::vector<int32_t> places(surface.ends.size(), -1);  // of triangles among those that are left
  for (size_t i = 0; i < places.size(); ++i)
    if (const size_t before = i == 0 ? 0 : cage.part_ends[i - 1]; cage.part_ends[i] > before)
      places[i] = int32_t(before);
  const auto move_faces = [&](Array<int32_t>* faces) {
    std::vector<int32_t> moved;
    for (const int32_t face : *faces)
      if (face >= 0 && size_t(face) < places.size() && places[size_t(face)] >= 0) moved.push_back(places[size_t(face)]);
    *faces = std::move(moved);
  };
  for (GeomSubset& subset : topology.geomSubsets) move_faces(&subset.indices);
  move_faces(&topology.invisibleFaces), move_faces(&topology.holeIndices);
  for (Array<int32_t>* tags : {&mesh->subdivTags.creaseIndices, &mesh->subdivTags.cornerIndices})
    *tags = points_of(*tags, cage.vertex_points);
  const size_t dropped = cage.dropped_faces;
  set_cage(surface, std::move(cage), mesh);
  return dropped;
}

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

namespace {

bool is_double_sided(const Document& document, const tinygltf::Primitive& primitive) {
  return primitive.material >= 0 && document.materials[size_t(primitive.material)].value("doubleSided", false);
}

std::string primitive_name(size_t primitive) {
  return element_name(".primitives", primitive);
}

// Only primitives of equal keys can be one mesh.
std::string mesh_key(const tinygltf::Primitive& primitive, bool mirrored) {
  return std::string(is_cage(primitive) ? "cage" : "triangles") + (mirrored ? " mirrored" : "");
}

std::vector<uint32_t> triangles_of(const Document& document, const tinygltf::Primitive& primitive) {
  const auto positions = primitive.attributes.find("POSITION");
  if (positions == primitive.attributes.end() || (primitive.mode >= 0 && primitive.mode < TINYGLTF_MODE_TRIANGLES))
    return {};
  std::vector<uint32_t> indices(document.accessors[size_t(positions->second)].count);
  std::iota(indices.begin(), indices.end(), 0u);
  if (primitive.indices >= 0) indices = read_indices(document.accessors[size_t(primitive.indices)]);
  return triangle_list(indices, primitive.mode < 0 ? TINYGLTF_MODE_TRIANGLES : primitive.mode);
}

// A subset for each primitive, if there are several. `ends` are those of their faces.
void set_subsets(const std::vector<size_t>& ends, MeshTopology* topology) {
  for (size_t first = 0, i = 0; i < ends.size() && ends.size() > 1; first = ends[i++]) {
    std::vector<int32_t> faces(ends[i] - first);
    std::iota(faces.begin(), faces.end(), int32_t(first));
    topology->geomSubsets.push_back({{}, {}, Array<int32_t>(std::move(faces))});
  }
}

// Counts the points of a cage where normals differ by more than 30 degrees, that is, hard edges, which refinement
// rounds.
size_t count_hard_points(const std::vector<Vec3f>& normals, const Cage& cage) {
  constexpr float kLeastCosine = 0.866f;
  if (normals.size() != cage.vertex_points.size()) return 0;  // some primitive has none
  std::vector<char> hard(cage.point_vertices.size(), 0);
  for (size_t vertex = 0; vertex < normals.size(); ++vertex) {
    const auto point = size_t(cage.vertex_points[vertex]);
    const Vec3f &n = normals[vertex], &first = normals[cage.point_vertices[point]];
    if (n.length2() > 0 && first.length2() > 0 && n.dot(first) < kLeastCosine) hard[point] = 1;
  }
  return size_t(std::count(hard.begin(), hard.end(), 1));
}

// Without paths. No faces: all are degenerate (a fault).
host::MeshDescription describe(Surface surface, int refine_level, const std::string& element,
                               std::vector<MeshFault>* faults) {
  host::MeshDescription mesh;
  if (surface.vertices.mirrored) mesh.topology.orientation = "leftHanded";
  if (surface.rest.empty()) {
    for (size_t& end : surface.ends) end /= 3;
    set_subsets(surface.ends, &mesh.topology);
    set_triangles(std::move(surface), &mesh);
    return mesh;
  }
  Cage cage = build_cage(surface.triangles, surface.rest, surface.ends);
  if (cage.dropped_faces > 0)
    faults->push_back(
        {"mesh.degenerate", element, std::to_string(cage.dropped_faces) + " faces have no area and are left out"});
  if (const size_t hard = count_hard_points(surface.vertices.normals, cage); hard > 0 && refine_level > 0)
    faults->push_back(
        {"mesh.ngon", element,
         "FB_ngon_encoding makes it a control mesh, and refinement rounds the hard edges that its normals have at " +
             std::to_string(hard) + " of " + std::to_string(cage.point_vertices.size()) +
             " points (assimp marks every mesh); \"scheme\": \"none\" in a render description draws it as it is"});
  mesh.displayStyle.refineLevel = refine_level;
  set_subsets(cage.part_ends, &mesh.topology);
  set_cage(surface, std::move(cage), &mesh);
  return mesh;
}

// Those with triangles. The others are faults here, or are reported by check_meshes().
std::vector<Piece> read_pieces(const Document& document, size_t index, const PrimitiveShape& shape,
                               std::vector<MeshFault>* faults) {
  const std::vector<tinygltf::Primitive>& primitives = document.model.meshes[index].primitives;
  std::vector<Piece> pieces;
  for (size_t p = 0; p < primitives.size(); ++p) {
    const tinygltf::Primitive& primitive = primitives[p];
    if (primitive.mode >= 0 && primitive.mode < TINYGLTF_MODE_TRIANGLES)
      faults->push_back({"mesh.mode", primitive_name(p) + ".mode", "points and lines are not drawn; use triangles"});
    std::vector<uint32_t> triangles = triangles_of(document, primitive);
    if (triangles.empty()) continue;
    const size_t count = document.accessors[size_t(primitive.attributes.at("POSITION"))].count;
    VertexReader reader{document, primitive, take_used(count, &triangles), shape.weights};
    SkinnedVertices vertices = read_vertices(reader, shape.joint_matrices);
    std::string key = mesh_key(primitive, vertices.mirrored);
    pieces.push_back({p, std::move(reader), std::move(vertices), std::move(triangles), std::move(key)});
  }
  return pieces;
}

// For each piece the first of its mesh. No pose changes them, because the positions are those at rest.
std::vector<size_t> meshes_of(const std::vector<Piece>& pieces) {
  std::vector<std::vector<Vec3f>> rest;
  std::vector<SurfacePiece> surfaces;
  if (pieces.size() < 2) return std::vector<size_t>(pieces.size());
  rest.reserve(pieces.size());
  for (const Piece& piece : pieces) {
    rest.push_back(to_vectors<Vec3f>(piece.reader.read_at_rest("POSITION")));
    surfaces.push_back({piece.key, &rest.back(), &piece.triangles});
  }
  return surfaces_of(surfaces);
}

}  // namespace

TranslatedMesh translate_mesh(const Document& document, size_t index, const PrimitiveShape& shape) {
  constexpr size_t kMostPoints = std::numeric_limits<int32_t>::max();
  TranslatedMesh translated;
  std::vector<MeshPart>& parts = translated.parts;
  std::vector<Piece> pieces = read_pieces(document, index, shape, &translated.faults);
  const std::vector<size_t> first = meshes_of(pieces);
  std::vector<Surface> surfaces;
  std::map<size_t, size_t> places;   // of a mesh in `parts`, by its first piece
  std::map<size_t, Surface> shapes;  // what its pieces have
  for (size_t i = 0; i < pieces.size(); ++i) {
    shapes[first[i]].has_normals |= !pieces[i].vertices.normals.empty();
    shapes[first[i]].has_tangents &= !pieces[i].vertices.tangents.empty();
  }
  for (size_t i = 0; i < pieces.size(); ++i) {
    Piece& piece = pieces[i];
    size_t& place = places.try_emplace(first[i], parts.size()).first->second;
    const size_t most =
        std::max(piece.vertices.points.size(), piece.triangles.size());  // without NORMAL, see flatten()
    if (place < parts.size() && most > kMostPoints - surfaces[place].vertices.points.size()) place = parts.size();
    if (place == parts.size()) parts.emplace_back(), surfaces.push_back(shapes[first[i]]);
    parts[place].primitives.push_back(piece.primitive);
    surfaces[place].add(std::move(piece));
  }
  for (size_t i = 0; i < parts.size(); ++i) {
    const std::vector<size_t>& primitives = parts[i].primitives;
    parts[i].mesh =
        describe(std::move(surfaces[i]), shape.refine_level, primitive_name(primitives[0]), &translated.faults);
    parts[i].mesh.doubleSided = std::all_of(primitives.begin(), primitives.end(), [&](size_t primitive) {
      return is_double_sided(document, document.model.meshes[index].primitives[primitive]);
    });
  }
  std::erase_if(parts, [](const MeshPart& part) { return part.mesh.topology.faceVertexCounts.empty(); });
  return translated;
}

}  // namespace alabaster::hd::gltf
