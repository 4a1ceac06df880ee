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
  std::vector<float> map;  // rows top-down, one value per pixel, from 0 (equal) to 1 (as different as possible)
  double mean = 0;         // over the map: the single number that the authors recommend
};

/// Both images are display-referred sRGB (as in a .png, 0 to 1). Values outside are clamped, and NaN is black.
/// Exchanging the two changes nothing. If the sizes differ, an image is empty, or pixels per degree lie outside 1 to
/// 1000, the map is empty and the mean NaN. Any thread; takes about 0.6 s for a megapixel on one core.
FlipDifference flip_difference(const Image& reference, const Image& test, float pixels_per_degree = kPixelsPerDegree);

}  // namespace alabaster::tradeoff
