// Points -> one sphere, and an instancer's record that places it.
#pragma once

#include "delegate/prims/mesh_cage.h"
#include "delegate/support/instancing.h"

namespace alabaster::hd::prims {

/// Gives points the shape of a sphere of radius 1 in place of their own values; constant ones stay, others are
/// reported. Its volume is exact, and its outline within a thousandth of the radius. All spheres share their arrays.
void make_sphere_of(PulledMesh* points, const std::string& where, const alabaster::DiagnosticSink& sink);

/// Of a primvar of points: one that is not constant is reported, and is gone then.
void keep_constant(const std::string& name, const std::string& where, const alabaster::DiagnosticSink& sink,
                   PulledPrimvar* primvar);

struct PlacedPoints {
  support::InstancePoints points;
  TimeSamples<support::InstancePoints> moving;
  Array<int32_t> drawn;  // among the points: those with a width above 0
};
/// Faults are reported.
PlacedPoints place_points(const PulledMesh& pulled, const std::string& where, const alabaster::DiagnosticSink& sink);

}  // namespace alabaster::hd::prims
