// From a matrix to the chromaticities that files carry.
#pragma once

#include <array>
#include <optional>

namespace alabaster {

/// CIE xy of red, green, blue, white.
using Chromaticities = std::array<float, 8>;

inline constexpr Chromaticities kRec709 = {0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.3290f};

/// A linear space as three columns: CIE XYZ, adapted to D65 by Bradford, of its red, green and blue unit vectors. Any
/// common scale is allowed.
using XyzColumns = std::array<std::array<double, 3>, 3>;

/// Columns of a space with these chromaticities, white scaled to Y = 1.
XyzColumns xyz_d65_columns(const Chromaticities& chromaticities);

/// The rows of the matrix from linear values of one space to those of another, white to white; from CIE XYZ, D65 to
/// white. Empty where one of them is no space of colours.
std::optional<std::array<std::array<float, 3>, 3>> rgb_to_rgb(const Chromaticities& from, const Chromaticities& to);

/// The native chromaticities when the columns are those of a well-known space (Rec.709, ACES AP0 and AP1, P3-D65,
/// Rec.2020): an adapted matrix no longer holds the space's own white, so the space is recognised instead. Else the
/// columns' own xy, which describe the space relative to D65. Rec.709 when the columns describe no space at all.
Chromaticities chromaticities_of(const XyzColumns& columns);

}  // namespace alabaster
