// Curves -> closed tubes, as a mesh prim would have pulled them.
#pragma once

#include "core/diagnostics/cancel.h"
#include "delegate/prims/mesh_cage.h"

namespace alabaster::hd::prims {

struct Tubes {
  PulledMesh mesh;
  NamedPrimvars named;
  MemoryReservation memory;
};

/// Each curve is a tube of 12 sides (6 where the prim has more than 100,000 segments), whose cross-section has the area
/// of the round one, across each corner too. Its ends are flat, or a tip where its width is 0. Between corners of more
/// than 120 degrees a curve is several tubes. The sides do not twist about the curve: their frame turns by the least
/// rotation from one section to the next, to which the double reflection of Wang, Juettler, Zheng and Liu ("Computation
/// of Rotation Minimizing Frames", ACM TOG 27, 2008) comes down where tangents are those of sections. In closed curves
/// the sections share what is left of the turn.
///
/// Values by curve become values by face, all others values by vertex. Curves that cannot be drawn are reported and
/// left out. Throws MemoryRefused before the tubes are made, and BuildCancelled.
Tubes make_tubes(const PulledMesh& curves, const NamedPrimvars& named, const std::string& where,
                 const alabaster::DiagnosticSink& sink, const std::shared_ptr<MemoryBudget>& budget,
                 const CancelToken& cancel);

}  // namespace alabaster::hd::prims
