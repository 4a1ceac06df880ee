// How the Disney BSDF treats energy.
#pragma once

#include <algorithm>

#include "core/color/rgb.h"

namespace alabaster {

/// The published lobes are added one upon the other, so that together they may reflect more than they receive.
enum class EnergyModel {
  burley2015,  // as published
  bounded,     // as published wherever it keeps energy; where the sum would exceed 1, lobes are dimmed
  conserving   // bounded, and specular reflection gets back what facets take from it on the way to others
};

/// The shares of the lobes that are kept for light from one direction. A pair of directions has the lesser of their
/// shares, so that the BSDF stays reciprocal.
struct KeptShares {
  Rgb base{1.0f};      // diffuse, sheen, diffuse transmission: they yield first
  Rgb specular{1.0f};  // specular and clearcoat: they yield where the walk's share and they leave no room
};

inline Rgb lesser(const Rgb& a, const Rgb& b) {
  return {std::min(a.r, b.r), std::min(a.g, b.g), std::min(a.b, b.b)};
}
inline KeptShares lesser(const KeptShares& a, const KeptShares& b) {
  return {lesser(a.base, b.base), lesser(a.specular, b.specular)};
}

}  // namespace alabaster
