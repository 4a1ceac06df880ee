// LDR-FLIP: how different two pictures look to somebody who flips between them. Andersson, Nilsson, Akenine-Moller,
// Oskarsson, Astrom, Fairchild: "FLIP: A Difference Evaluator for Alternating Images", Proc. ACM Comput. Graph.
// Interact. Tech. 3(2), 2020. Written from the paper and its erratum (features are sought in luminance, (Y + 16) /
// 116).
#pragma once

#include <vector>

#include "delegate/tradeoff/image.h"

namespace alabaster::tradeoff {

/// The paper's viewer: 0.7 m from a display that is 0.7 m wide and has 3840 columns.
inline constexpr float kPixelsPerDegree = 67;

struct FlipDifference {
  std::vector<float> map;  // rows top-down, one value a pixel: 0 equal to 1 as different as can be
  double mean = 0;         // over the map: what the authors recommend as the one number
};

/// Both images are display-referred sRGB (as a .png holds them, 0 to 1); what lies outside is clamped, a NaN is black.
/// Exchanging the two changes nothing. Pictures of different or no size have no difference: the map is empty and the
/// mean a NaN; so it is for pixels per degree outside 1 to 1000. Any thread; takes about 0.6 s for a
/// megapixel on one core.
FlipDifference flip_difference(const Image& reference, const Image& test, float pixels_per_degree = kPixelsPerDegree);

}  // namespace alabaster::tradeoff
