// Displacement: a material moves the points of a mesh before the mesh is traced.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/material/texture_lookup.h"

namespace alabaster {

/// The meaning of a displacement texture's value.
enum class DisplacementSpace {
  normal,   // a height along the surface's normal
  tangent,  // a vector (t, b, n): along the direction in which u grows, across it (as v grows), along the normal
  object    // a vector in the mesh's object space
};

/// The displacement is (value - midlevel) * scale, in the mesh's object space and units.
struct Displacement {
  TextureLookup texture;
  DisplacementSpace space = DisplacementSpace::normal;
  Channel channel = Channel::r;  // of a height
  float scale = 1;
  float midlevel = 0;
  bool operator==(const Displacement&) const = default;
};

/// By the mesh's material slot, as InstanceDescription::materials; slots beyond the list use the first.
using Displacements = std::vector<std::optional<Displacement>>;

/// Moves the mesh's points and recomputes its normals. Nothing else of the mesh has to be complete but its attributes;
/// its tangents, which would be those of the old surface, are dropped.
/// - Points at the same position stay at the same position, so that closed meshes stay closed: each moves by the mean
///   over the triangle corners that meet there, weighted by their angles, of what the texture says at each corner.
///   Corners differ at seams of the texture coordinates and between materials; one without displacement counts as 0. A
///   height moves a point along the mean of its corners' normals.
/// - A normal is the mean of the displaced triangles around its point (Max 1999, "Weights for Computing Vertex Normals
///   from Facet Normals"), over the corners that had the same normal before: smooth surfaces stay smooth, and hard
///   edges hard. Errors shrink with the distance between points. Flat meshes stay flat.
/// - Where a displaced point would not be finite, or beyond kTraceLimit, it keeps its place, and one error is reported.
/// - A texture whose coordinates the mesh lacks is read at (0, 0), as everywhere, and a warning is reported.
void displace(const Displacements& displacements, const std::string& where, const DiagnosticSink& sink, Mesh* mesh,
              const CancelToken& cancel = {});

}  // namespace alabaster
