// Numbers of any type as the floats that the renderer computes with.
#pragma once

#include "delegate/api/types.h"

namespace alabaster::hd::support {

/// Arrays of numbers, and of vectors of two to four numbers, of any type, as arrays of float, Vec2f, Vec3f or Vec4f;
/// one number or vector as an array of one. Quath becomes Quatf. Memory that the host edits in place is copied; arrays
/// of floats that are never edited are not. All other values stay as they are.
Value FloatValues(const Value& value);

}  // namespace alabaster::hd::support
