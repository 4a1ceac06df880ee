// A cage in OpenSubdiv's terms. Used by subdivision.cpp.
#pragma once

#include <opensubdiv/far/topologyRefiner.h>

#include <memory>
#include <string>

#include "core/geometry/cage.h"

namespace alabaster {

/// The topology of a sanitized cage with its scheme, rules, creases, corners and holes; face-varying uvs
/// are channels, in their order.
/// Faces wind counter-clockwise. Null if OpenSubdiv refuses it; `messages` takes what it has to say. Any thread.
std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> make_refiner(const Cage& cage, std::string* messages);

}  // namespace alabaster
