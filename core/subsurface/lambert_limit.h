// Lambert's diffuse in place of subsurface scattering, where a pixel shows no difference: the `auto` mode's criterion.
//
// A Lambert reflection of the albedo that the medium obtains has the walk's energy on a slab. It lacks the walk's
// blur, and the light that comes through thin parts. Each is allowed to change a pixel by at most
// kLambertTolerance of the contrast around it, one step of eight bits:
//
//   blur       a hard shadow edge, at worst on a pixel's border, moves E[max(x, 0)]/w = reach/(pi w) across it, for a
//              footprint of width w and the mean exit radius `reach` (E|x| = 2/pi E[r] in a plane). Lambert is chosen
//              with a probability p(w/reach) that rises from 0 to 1 while p times that stays below kLambertTolerance: a
//              stochastic blend, with no seam in the picture.
//   thickness  an isotropic slab of thickness L mean free paths lets through, in diffusion theory,
//              (4/3) kappa / sinh(kappa (L + 1.4209)), kappa = sqrt(3 (1 - alpha)). A ray in a direction of the entry's
//              cosine lobe must cross a random 1 to 2 times the L at which that is the tolerance and meet nothing: so
//              near edges, in folds and in thin parts the walk is kept, in proportion, even where a pixel covers them
//              all.
//
// A = 1 has no mean exit radius (its profile falls as r^-3), and is always walked.
#pragma once

#include "core/diagnostics/counters.h"
#include "core/subsurface/body.h"
#include "core/subsurface/entry_exit.h"

namespace alabaster {

inline constexpr double kLambertTolerance = 1.0 / 256;

/// The reach of light in a medium. World units, of the channel where each is largest.
struct LightReach {
  float exit_radius = 0;   // mean distance between entry and exit
  float opaque_depth = 0;  // thickness of a slab that lets kLambertTolerance through
};
LightReach light_reach(const Medium& medium);

/// Probability of Lambert at a footprint `width` (world): 0 up to 24 exit radii, 1 from 98 on, between them a
/// smoothstep over the logarithm.
float lambert_probability(float width, const LightReach& reach);

/// The carrier that reflects light where it entered, with the energy that a walk would bring out, where a pixel cannot
/// tell the two apart. Empty: it can, and the walk has to be taken. Both branches weigh one: the picture is their
/// blend. All numbers come from `u`: 0 decides, 1 to 3 sample the ray that asks how thick the body is.
struct LambertLimit {
  AlbedoInversion inversion = AlbedoInversion::exact;
  float footprint = 0;  // world: width of what the path stands for at the entry

  std::optional<SubsurfaceExit> carry(const SubsurfaceBody& body, const SubsurfaceEntry& entry,
                                      SubsurfaceNumbers& numbers, RenderCounters& counters) const;
};

}  // namespace alabaster
