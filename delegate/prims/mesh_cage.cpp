#include "delegate/prims/mesh_cage.h"

#include <algorithm>
#include <span>
#include <utility>

#include "core/geometry/subdivision.h"
#include "delegate/support/lookup.h"
#include "delegate/support/mesh_words.h"

namespace alabaster::hd::prims {
namespace {

struct Reporter {
  const alabaster::DiagnosticSink& sink;
  const std::string& where;
  void warn(const char* code, const std::string& text) const {
    alabaster::report(sink, alabaster::Severity::warning, code, where, text);
  }
};

/// The value of an enumeration whose words are given in its order.
template <class Enum>
void set_word(const Token& token, std::span<const char* const> words, const char* what, const Reporter& reporter,
              Enum* value) {
  if (token.empty()) return;
  const auto found = std::find(words.begin(), words.end(), token.str());
  if (found == words.end())
    return reporter.warn("mesh.token", std::string(what) + " '" + token.str() + "' is not known; the default is used");
  *value = static_cast<Enum>(found - words.begin());
}

template <class T>
std::vector<T> copy(const Array<T>& array) {
  return std::vector<T>(array.begin(), array.end());
}

bool draws(const GeomSubset& subset) {
  return !subset.materialId.empty() && !subset.indices.empty();
}

void set_tags(const PulledMesh& mesh, const Reporter& reporter, Cage* cage) {
  const SubdivTags& t = mesh.tags;
  set_word(mesh.topology.scheme, support::kSubdivisionSchemes, "subdivision scheme", reporter, &cage->scheme);
  set_word(mesh.topology.orientation, support::kOrientations, "orientation", reporter, &cage->left_handed);
  set_word(t.interpolateBoundary, support::kBoundaryRules, "interpolateBoundary", reporter, &cage->boundary_rule);
  set_word(t.faceVaryingLinearInterpolation, support::kFaceVaryingRules, "faceVaryingLinearInterpolation", reporter,
           &cage->face_varying_rule);
  set_word(t.creaseMethod, support::kCreaseMethods, "creaseMethod", reporter, &cage->crease_method);
  set_word(t.triangleSubdivision, support::kTriangleSubdivisions, "triangleSubdivision", reporter,
           &cage->triangle_subdivision);
  cage->crease_indices = copy(t.creaseIndices);
  cage->crease_lengths = copy(t.creaseLengths);
  cage->crease_sharpnesses = copy(t.creaseWeights);
  cage->corner_indices = copy(t.cornerIndices);
  cage->corner_sharpnesses = copy(t.cornerWeights);
}

template <class T>
bool set_interpolation(const PulledPrimvar& pulled, const char* name, const Reporter& reporter,
                       alabaster::Primvar<T>* out) {
  constexpr alabaster::Interpolation kOurs[] = {alabaster::Interpolation::constant, alabaster::Interpolation::uniform,
                                                alabaster::Interpolation::varying, alabaster::Interpolation::vertex,
                                                alabaster::Interpolation::face_varying};
  if (pulled.interpolation == hd::Interpolation::instance) {
    reporter.warn("mesh.primvar.interpolation",
                  std::string("primvar ") + name + " of a mesh cannot be one per instance; it is left out");
    return false;
  }
  out->interpolation = kOurs[static_cast<size_t>(pulled.interpolation)];
  return true;
}

template <class T>
alabaster::Primvar<T> primvar(const PulledPrimvar& pulled, const char* name, const Reporter& reporter) {
  alabaster::Primvar<T> out;
  if (!pulled.present || pulled.value.empty()) return out;
  const auto* values = pulled.value.get<Array<T>>();
  if (!values) {
    reporter.warn("mesh.primvar.type", std::string("primvar ") + name + " has an unexpected type; it is left out");
    return out;
  }
  if (!set_interpolation(pulled, name, reporter, &out)) return out;
  out.values = copy(*values);
  out.indices = copy(pulled.indices);
  return out;
}

NamedPrimvar named_primvar(const PulledPrimvar& pulled, const std::string& name, const Reporter& reporter) {
  NamedPrimvar out{{}, name};
  const auto read = [&]<class T>(const Array<T>* array) {
    if (array) out.values = primvar<T>(pulled, name.c_str(), reporter);
    return array != nullptr;
  };
  const Value& v = pulled.value;
  const bool known = read(v.get<Array<float>>()) || read(v.get<Array<Vec2f>>()) || read(v.get<Array<Vec3f>>()) ||
                     read(v.get<Array<Vec4f>>());
  if (!known && !v.empty())
    reporter.warn("mesh.primvar.type", "primvar " + name + " is not of numbers; it is left out");
  if (auto* const colors = std::get_if<alabaster::Primvar<Vec3f>>(&out.values); colors && pulled.to_rendering)
    for (Vec3f& value : colors->values) {
      const Rgb color = (*pulled.to_rendering)(Rgb(value.x, value.y, value.z));
      value = {color.r, color.g, color.b};
    }
  return out;
}

const PulledPrimvar* find_primvar(const PulledMesh& mesh, const NamedPrimvars& named, const Token& name) {
  for (const auto& [known, primvar] : kPulledPrimvars)
    if (name == Token(known)) return &(mesh.*primvar);
  if (const auto uvs = mesh.uvs.find(name); uvs != mesh.uvs.end()) return &uvs->second;
  return named.find(name);
}

// for_each_buffer(visit, value) calls visit(data, bytes) for each array of a value that is not empty.
template <class Visit, class... T>
void for_each_buffer(const Visit& visit, const Array<T>&... arrays) {
  const auto one = [&](const auto& array) {
    if (!array.empty()) visit(array.data(), array.size() * sizeof(*array.data()));
  };
  (one(arrays), ...);
}

template <class Visit>
void for_each_buffer(const Visit& visit, const Value& value) {
  if (const NumberArray all = numbers_of(value); all.data) visit(all.data, all.count * all.width * sizeof(float));
}

template <class Visit>
void for_each_buffer(const Visit& visit, const PulledPrimvar& primvar) {
  for_each_buffer(visit, primvar.value);
  for_each_buffer(visit, primvar.indices);
}

template <class Visit>
void for_each_buffer(const Visit& visit, const TimeSamples<Value>& samples) {
  for (const Value& value : samples.values) for_each_buffer(visit, value);
}

template <class Visit>
void for_each_buffer(const Visit& visit, const PulledMesh& mesh) {
  for (const auto& [name, primvar] : kPulledPrimvars) for_each_buffer(visit, mesh.*primvar);
  for (const auto& [name, uv] : mesh.uvs) for_each_buffer(visit, uv);
  const MeshTopology& t = mesh.topology;
  const SubdivTags& tags = mesh.tags;
  for_each_buffer(visit, t.faceVertexCounts, t.faceVertexIndices, t.holeIndices, t.invisibleFaces, tags.creaseIndices,
                  tags.creaseLengths, tags.cornerIndices, tags.creaseWeights, tags.cornerWeights,
                  mesh.curves.curveVertexCounts);
  for_each_buffer(visit, mesh.point_samples);
  for_each_buffer(visit, mesh.normal_samples);
}

template <class Visit>
void for_each_buffer(const Visit& visit, const FaceSlots& slots) {
  for (const Array<int32_t>& faces : slots.faces) for_each_buffer(visit, faces);
}

template <class Visit>
void for_each_buffer(const Visit& visit, const OtherPrimvars& primvars) {
  for (const auto& [name, primvar] : primvars.by_name) for_each_buffer(visit, primvar);
}

template <class T>
size_t bytes_in(const T& value) {
  size_t all = 0;
  for_each_buffer([&](const void*, size_t bytes) { all += bytes; }, value);
  return all;
}

}  // namespace

const PulledPrimvar* NamedPrimvars::find(const Token& name) const {
  return others ? support::find_in(others->by_name, name) : nullptr;
}

bool NamedPrimvars::operator==(const NamedPrimvars& other) const {
  const auto is_same = [&](const Token& name) {
    const PulledPrimvar *a = find(name), *b = other.find(name);
    return a == b || (a && b && *a == *b);
  };
  return names == other.names && (others == other.others || std::all_of(names.begin(), names.end(), is_same));
}

NumberArray numbers_of(const Value& value) {
  constexpr size_t kNumberBytes = sizeof(float);
  NumberArray found;
  const auto take = [&]<class T>(const Array<T>* array) {
    if (array && !array->empty())
      found = {reinterpret_cast<const float*>(array->data()), sizeof(T) / kNumberBytes, array->size()};
  };
  take(value.get<Array<float>>()), take(value.get<Array<Vec2f>>());
  take(value.get<Array<Vec3f>>()), take(value.get<Array<Vec4f>>());
  return found;
}

static_assert(kMaxRefineLevel == kMaxSubdivisionLevel);
int refine_level(const PulledMesh& mesh) {
  return is_refined(mesh) ? std::clamp(mesh.style.refineLevel, 0, kMaxSubdivisionLevel) : 0;
}

Cage make_cage(const PulledMesh& mesh, const NamedPrimvars& named, const std::string& where,
               const alabaster::DiagnosticSink& sink) {
  const Reporter reporter{sink, where};
  Cage cage;
  set_tags(mesh, reporter, &cage);
  cage.face_vertex_counts = copy(mesh.topology.faceVertexCounts);
  cage.face_vertex_indices = copy(mesh.topology.faceVertexIndices);
  cage.hole_indices = copy(mesh.topology.holeIndices);
  cage.invisible_faces = copy(mesh.topology.invisibleFaces);
  if (const auto* points = mesh.points.value.get<Array<Vec3f>>())
    cage.points = copy(*points);
  else if (!mesh.points.value.empty())
    reporter.warn("mesh.points.type", "points must be an array of three numbers each; nothing is drawn");
  if (!mesh.points.indices.empty())
    reporter.warn("mesh.points.indices", "the indices of points are not used: faceVertexIndices alone name the points");
  cage.normals = primvar<Vec3f>(mesh.normals, "normals", reporter);
  cage.tangents = primvar<Vec4f>(mesh.tangents, "tangents", reporter);
  for (const auto& [name, pulled] : mesh.uvs)
    cage.uvs.push_back({primvar<Vec2f>(pulled, name.str().c_str(), reporter), name.str()});
  const auto add = [&](const PulledPrimvar* found, const std::string& name) {
    if (found && found->present) cage.primvars.push_back(named_primvar(*found, name, reporter));
  };
  add(&mesh.display_color, kDisplayColor), add(&mesh.display_opacity, kDisplayOpacity);
  for (const Token& name : named.names) add(find_primvar(mesh, named, name), name.str());
  return cage;
}

size_t memory_bytes(const PulledMesh& mesh, const NamedPrimvars& named) {
  size_t all = bytes_in(mesh);
  for (const Token& name : named.names)
    if (const PulledPrimvar* const found = find_primvar(mesh, named, name)) all += bytes_in(*found);
  return all;
}

template <class T>
void hold_arrays(T* value, BufferReservations* buffers, const std::string& where) {
  SharedReservations all;
  for_each_buffer([&](const void* data, size_t bytes) { all.held.push_back(buffers->hold(data, bytes, where)); },
                  *value);
  value->memory = std::move(all);
}
template void hold_arrays(PulledMesh*, BufferReservations*, const std::string&);
template void hold_arrays(FaceSlots*, BufferReservations*, const std::string&);
template void hold_arrays(OtherPrimvars*, BufferReservations*, const std::string&);

std::vector<int32_t> slots_of_faces(const FaceSlots& slots, size_t count, const std::string& where,
                                    const alabaster::DiagnosticSink& sink) {
  if (slots.faces.empty()) return {};
  std::vector<int32_t> of_faces(count, 0);
  size_t outside = 0;
  int32_t slot = 0;
  for (const Array<int32_t>& faces : slots.faces) {
    ++slot;
    for (const int32_t face : faces) {
      if (face >= 0 && static_cast<size_t>(face) < count)
        of_faces[static_cast<size_t>(face)] = slot;
      else
        ++outside;
    }
  }
  if (outside)
    Reporter{sink, where}.warn("mesh.subset.range",
                               std::to_string(outside) + " faces of subsets do not exist; they are ignored");
  return of_faces;
}

FaceSlots face_slots(const std::vector<GeomSubset>& subsets) {
  FaceSlots slots;
  for (const GeomSubset& subset : subsets)
    if (draws(subset)) slots.faces.push_back(subset.indices);
  return slots;
}

std::vector<Path> slot_materials(const std::vector<GeomSubset>& subsets, const Path& material) {
  std::vector<Path> materials{material};
  for (const GeomSubset& subset : subsets)
    if (draws(subset)) materials.push_back(subset.materialId);
  return materials;
}

}  // namespace alabaster::hd::prims
