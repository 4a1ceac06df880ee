// The colour of a glowing body by its temperature.
#pragma once

#include "core/color/chromaticities.h"
#include "core/color/rgb.h"

namespace alabaster {

/// The colour of a blackbody of this temperature (kelvin, 1000 to 15000; others are clamped) and luminance 1, in a
/// linear space of these chromaticities. UsdLux computes it so: against a white of D65, and not adapted to it, so that
/// 6500 K is nearly white and not exactly (OpenUSD's hdEmbree does the same). Channels of colours outside the space,
/// below about 1900 K in Rec.709, are cut at 0.
///
/// Krystek 1985, "An algorithm to calculate correlated colour temperature": rational functions for the CIE 1960 uv of
/// the Planckian locus, right to 1e-4.
Rgb blackbody(float kelvin, const Chromaticities& space);

}  // namespace alabaster
