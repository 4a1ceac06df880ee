// Animations (glTF 2.0, section 3.11).
#pragma once

#include <span>

#include "delegate/gltf/gltf_document.h"

namespace alabaster::hd::gltf {

/// The keys of a sampler: at each time a value of `components` numbers, or with CUBICSPLINE an in-tangent, a value and
/// an out-tangent.
struct AnimationCurve {
  std::string interpolation;     // STEP, LINEAR or CUBICSPLINE
  std::span<const float> times;  // increasing, at least one
  std::span<const float> values;
  size_t components = 1;
  bool rotation = false;  // unit quaternions (x, y, z, w): LINEAR goes along the shorter arc
};

/// The value at `time`; before the first key the first, after the last key the last.
std::vector<double> sample(const AnimationCurve& curve, double time);

/// Sets the transforms and morph weights of the nodes that the document's animation moves, as they are at `seconds`.
void apply_animation(double seconds, Document* document);

}  // namespace alabaster::hd::gltf
