// A mesh in the contract's words -> a cage in core's.
#pragma once

#include <map>

#include "core/color/rgb.h"
#include "core/geometry/cage.h"
#include "core/memory/memory_budget.h"
#include "delegate/api/scene_types.h"

namespace alabaster::hd::prims {

struct PulledPrimvar {
  bool present = false;
  hd::Interpolation interpolation = hd::Interpolation::vertex;
  Value value;
  Array<int32_t> indices;
  std::shared_ptr<const RgbMatrix> to_rendering = {};  // of its colours; null: they are in that space
  bool operator==(const PulledPrimvar&) const = default;
};

/// An array of numbers or of vectors of them, as floats. Null: it is of another type, or empty.
struct NumberArray {
  const float* data = nullptr;
  size_t width = 0, count = 0;
};
NumberArray numbers_of(const Value& value);

/// The values that a mesh prim has pulled so far: numbers of any type as floats (support::FloatValues). Arrays are
/// shared with the scene delegate, unless they had to be converted or the host edits them in place.
struct PulledMesh {
  MeshTopology topology;       // without its subsets: see FaceSlots
  BasisCurvesTopology curves;  // in its place, where there are any: tubes are made of them (tubes.h)
  SubdivTags tags;
  DisplayStyle style;
  PulledPrimvar points, normals, tangents, display_color, display_opacity, widths;
  TimeSamples<Value> point_samples, normal_samples;
  std::map<Token, PulledPrimvar> uvs;  // texture coordinates by name
  SharedReservations memory;
};

/// What a mesh without a material shows; built whether or not they are asked for.
inline constexpr const char kDisplayColor[] = "displayColor", kDisplayOpacity[] = "displayOpacity";

struct PulledPrimvarName {
  const char* name;
  PulledPrimvar PulledMesh::*primvar;
};
constexpr PulledPrimvarName kPulledPrimvars[] = {{"points", &PulledMesh::points},
                                                 {"normals", &PulledMesh::normals},
                                                 {"tangents", &PulledMesh::tangents},
                                                 {kDisplayColor, &PulledMesh::display_color},
                                                 {kDisplayOpacity, &PulledMesh::display_opacity},
                                                 {"widths", &PulledMesh::widths}};
inline bool is_refined(const PulledMesh& mesh) {
  return !mesh.topology.scheme.empty() && !(mesh.topology.scheme == Token("none"));
}
/// 0: the cage is drawn.
int refine_level(const PulledMesh& mesh);

/// The faces of a mesh's material slots from 1 on; all others have slot 0. Where they overlap, the later slot wins.
struct FaceSlots {
  std::vector<Array<int32_t>> faces;
  SharedReservations memory = {};
  bool operator==(const FaceSlots&) const = default;
};

/// Primvars of other names of a mesh, or all by instance.
struct OtherPrimvars {
  std::map<Token, PulledPrimvar> by_name;
  SharedReservations memory = {};
  bool operator==(const OtherPrimvars&) const = default;
};

/// Has the memory budget hold all arrays, each once, however many meshes share it. Throws MemoryRefused, and then those
/// of before are held.
template <class T>  // PulledMesh, FaceSlots or OtherPrimvars
void hold_arrays(T* value, BufferReservations* buffers, const std::string& where);

/// The primvars of a mesh that its materials read or AOVs show.
struct NamedPrimvars {
  std::vector<Token> names;
  std::shared_ptr<const OtherPrimvars> others;  // null: none

  const PulledPrimvar* find(const Token& name) const;  // null: none among the others
  bool operator==(const NamedPrimvars&) const;         // of those of the names
};

/// Bytes of all arrays of its cage, its own and those of the host.
size_t memory_bytes(const PulledMesh& mesh, const NamedPrimvars& named);
/// The cage as it was given, faults included (sanitize_cage mends them), without material slots. Unknown words, and
/// primvars of another type or interpolation, are reported and left out.
Cage make_cage(const PulledMesh& mesh, const NamedPrimvars& named, const std::string& where,
               const alabaster::DiagnosticSink& sink);
/// The slot of each of `count` faces; empty: all 0. Faces that do not exist are reported and left out.
std::vector<int32_t> slots_of_faces(const FaceSlots& slots, size_t count, const std::string& where,
                                    const alabaster::DiagnosticSink& sink);

/// The faces of the subsets that have a material and are not empty: each is a slot.
FaceSlots face_slots(const std::vector<GeomSubset>& subsets);
/// Materials by slot: `material`, then those of the subsets.
std::vector<Path> slot_materials(const std::vector<GeomSubset>& subsets, const Path& material);

}  // namespace alabaster::hd::prims
