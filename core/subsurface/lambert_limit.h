// Where subsurface scattering cannot be told from Lambert's diffuse: the `auto` mode's criterion.
//
// A Lambert reflection of the albedo that the medium obtains has the walk's energy on a slab; what it lacks is the
// walk's blur, and the light that comes through thin parts. Each is allowed to change a pixel by at most
// kLambertTolerance of the contrast around it, one step of eight bits:
//
//   blur       a hard shadow edge, at worst on a pixel's border, moves E[max(x, 0)]/w = reach/(pi w) across it, for a
//              footprint of width w and the mean exit radius `reach` (E|x| = 2/pi E[r] in a plane). Lambert is chosen
//              with a probability p(w/reach) that rises from 0 to 1 while p times that stays below kLambertTolerance: a
//              stochastic blend, with no seam in the picture.
//   thickness  what an isotropic slab of thickness L mean free paths lets through is, in diffusion theory,
//              (4/3) kappa / sinh(kappa (L + 1.4209)), kappa = sqrt(3 (1 - alpha)). A ray in a direction of the entry's
//              cosine lobe must cross a random 1 to 2 times the L at which that is the tolerance and meet nothing: so
//              near edges, in folds and in thin parts the walk is kept, in proportion, even where a pixel covers them
//              all.
//
// A = 1 has no mean exit radius (its profile falls as r^-3), and is always walked.
#pragma once

#include "core/subsurface/medium.h"

namespace alabaster {

inline constexpr double kLambertTolerance = 1.0 / 256;

struct LambertLimit {
  float reach = 0;         // world: mean distance between entry and exit, of the channel where it is largest
  float opaque_depth = 0;  // world: a slab this thick lets kLambertTolerance through, ditto
};
LambertLimit lambert_limit(const Medium& medium);

/// Probability of Lambert at a footprint `width` (world): 0 up to 24 reaches, 1 from 98 on, between them a smoothstep
/// over the logarithm.
float lambert_probability(float width, const LambertLimit& limit);

}  // namespace alabaster
