// Points -> one sphere, and an instancer's record that places it.
#pragma once

#include "delegate/prims/mesh_cage.h"
#include "delegate/support/instancing.h"

namespace alabaster::hd::prims {

/// Gives points the shape of a sphere of radius 1. Its volume is exact, and its outline within a thousandth of the
/// radius. All spheres share their arrays.
void make_sphere_of(PulledMesh* points);

/// The primvars that have a value for each point, which are values by instance of the sphere; the constant ones stay.
std::map<Token, PulledPrimvar> take_values_by_point(PulledMesh* points, OtherPrimvars* others);

struct PlacedPoints {
  support::InstancePoints points;
  TimeSamples<support::InstancePoints> moving;
  Array<int32_t> drawn;  // among the points: those with a width above 0
};
/// Faults are reported.
PlacedPoints place_points(const PulledMesh& pulled, const std::string& where, const alabaster::DiagnosticSink& sink);

}  // namespace alabaster::hd::prims
