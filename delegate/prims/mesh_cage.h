// A mesh in the contract's words -> a cage in core's.
#pragma once

#include <map>

#include "core/geometry/cage.h"
#include "delegate/api/scene_types.h"

namespace alabaster::hd::prims {

struct PulledPrimvar {
  bool present = false;
  hd::Interpolation interpolation = hd::Interpolation::vertex;
  Value value;
  Array<int32_t> indices;
  bool operator==(const PulledPrimvar&) const = default;
};

/// The values that a mesh prim has pulled so far. Arrays are shared with the scene delegate, not copied.
struct PulledMesh {
  MeshTopology topology;
  SubdivTags tags;
  DisplayStyle style;
  PulledPrimvar points, normals, tangents, display_color, display_opacity;
  TimeSamples<Value> point_samples, normal_samples;
  std::map<Token, PulledPrimvar> uvs;  // texture coordinates by name
};

/// The cage as it was given, faults included (sanitize_cage mends them). Unknown words, primvars of another type or
/// interpolation, and subset faces that do not exist are reported and left out.
Cage make_cage(const PulledMesh& mesh, const std::string& where, const alabaster::DiagnosticSink& sink);

/// Materials by slot: `material`, then one for each subset that has one and is not empty.
std::vector<Path> slot_materials(const MeshTopology& topology, const Path& material);
/// True if the two differ at most in the materials that their subsets name.
bool same_shape(const MeshTopology& a, const MeshTopology& b);

}  // namespace alabaster::hd::prims
