// Points of a cage that nothing is made of.
#pragma once

#include "core/geometry/cage.h"

namespace alabaster {

/// Removes the points, with their values of primvars, that no face and no crease or corner of a sanitized cage names.
/// The surface stays as it is.
void drop_unused_points(Cage* cage);

}  // namespace alabaster
