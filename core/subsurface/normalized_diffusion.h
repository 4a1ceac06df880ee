// Normalized diffusion: subsurface scattering as a profile over the distance between entry and exit (Burley 2015,
// section 4; Christensen and Burley 2015). The paper measures its walk against this.
//
//   R(r) = A (e^{-r/d} + e^{-r/3d}) / (8 pi d r)        Int_plane R = A;  CDF 1 - e^{-r/d}/4 - 3 e^{-r/3d}/4
//
// r is the straight distance between the two points and d the scatter distance: Chiang, Kutz, Burley 2016 give the walk
// sigma_t = 1/(d s) so that its profile is this one. The lobe is the integral of R over the whole surface of the
// object.
//
// Sampling (King, Kulla, Conty, Fajardo 2013): a probe parallel to the normal or one of two tangents at the entry, at a
// distance from it that follows the profile, and every hit along it. Only the end of the probe is new. R falls with r,
// so it is a stack of uniform balls:
//
//   R(r)/A = Int_r^inf p(s)/(pi s^2) ds,   p(s) = -pi s^2 R'(s)/A = (1/8d) [(1 + s/d) e^{-s/d} + (1 + s/3d) e^{-s/3d}]
//
// Sample the radius s of a ball from p (a mixture of scales d, in 1/4, and 3d, in 3/4; in each, half an exponential and
// half a sum of two), a point uniform in the disk of that radius across the axis, and take the hits on the chord of the
// ball through it. The disk's points then follow the profile, as King's do, but no radius is too far to be found, so
// nothing is cut off; and the density with which axis k finds a surface point is P_k |N.V_k| R(r)/A, the same R for all
// three. The balance heuristic over axes and channels is left with
//
//   throughput_c = T_c A_c R_c(r) / (Sum_j w_j R_j(r) Sum_k P_k |N.V_k|),   w ~ T A,
//
// at most Sum_j T_j A_j / min P for one hit. One hit of those found goes on, chosen in proportion to its largest
// channel; it carries the weight of all.
#pragma once

#include "core/diagnostics/counters.h"
#include "core/subsurface/body.h"
#include "core/subsurface/entry_exit.h"

namespace alabaster {

/// Share of the normal's axis; the two tangents have half of the rest each. King et al. use 1/2, and where a surface is
/// flat every other probe is then in vain: 0.8 has half the variance on smooth bodies and the same on folded ones, at
/// the price of a larger bound. This lies between.
inline constexpr double kNormalAxisProbability = 0.7;
inline constexpr double kTangentAxisProbability = 0.5 * (1 - kNormalAxisProbability);

/// The radius of a ball of the stack, by p(s) above. `u` in [0,1) is the number that moves it most; the largest radius
/// that 24-bit numbers reach is 100 d, beyond which lie 1e-7 of the balls.
double sample_diffusion_ball(double d, float u, Rng& rng);

/// The carrier by the profile: light spreads over the member that it enters, and no further. `u`: 0 chooses axis and
/// channel, 1 the ball, 2 and 3 the point on its disk; the rest comes from the stream. Empty: the probe met nothing.
/// Balls so small that floats do not resolve them leave where they entered. May throw std::bad_alloc.
struct NormalizedDiffusion {
  std::optional<SubsurfaceExit> carry(const SubsurfaceBody& body, const SubsurfaceEntry& entry,
                                      SubsurfaceNumbers& numbers, RenderCounters& counters) const;
};

}  // namespace alabaster
