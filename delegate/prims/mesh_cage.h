// A mesh in the contract's words -> a cage in core's.
#pragma once

#include <map>

#include "core/geometry/cage.h"
#include "core/memory/memory_budget.h"
#include "delegate/api/scene_types.h"

namespace alabaster::hd::prims {

struct PulledPrimvar {
  bool present = false;
  hd::Interpolation interpolation = hd::Interpolation::vertex;
  Value value;
  Array<int32_t> indices;
  SharedReservation memory = {};
  bool operator==(const PulledPrimvar&) const = default;
};

/// The values that a mesh prim has pulled so far: numbers of any type as floats (support::FloatValues). Arrays are
/// shared with the scene delegate, unless they had to be converted or the host edits them in place.
struct PulledMesh {
  MeshTopology topology;
  SubdivTags tags;
  DisplayStyle style;
  PulledPrimvar points, normals, tangents, display_color, display_opacity;
  TimeSamples<Value> point_samples, normal_samples;
  std::map<Token, PulledPrimvar> uvs;  // texture coordinates by name
  SharedReservation topology_memory, samples_memory;
};

/// Bytes of all its arrays, its own and those of the host.
size_t memory_bytes(const PulledMesh& mesh);
/// Has the budget hold the arrays that it does not hold yet: a mesh and its copies hold each once. Throws
/// MemoryRefused.
void hold_arrays(PulledMesh* mesh, const std::shared_ptr<MemoryBudget>& budget, const std::string& where);

/// Primvars that no material reads, by name.
using OtherPrimvars = std::map<Token, PulledPrimvar>;

/// The primvars of a mesh that AOVs show.
struct NamedPrimvars {
  std::vector<Token> names;
  std::shared_ptr<const OtherPrimvars> others;  // null: none
  bool operator==(const NamedPrimvars&) const = default;
};

/// The cage as it was given, faults included (sanitize_cage mends them). Unknown words, primvars of another type or
/// interpolation, and subset faces that do not exist are reported and left out.
Cage make_cage(const PulledMesh& mesh, const NamedPrimvars& named, const std::string& where,
               const alabaster::DiagnosticSink& sink);

/// Materials by slot: `material`, then one for each subset that has one and is not empty.
std::vector<Path> slot_materials(const MeshTopology& topology, const Path& material);
/// True if the two differ at most in the materials that their subsets name.
bool same_shape(const MeshTopology& a, const MeshTopology& b);

}  // namespace alabaster::hd::prims
