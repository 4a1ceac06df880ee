// Surfaces that light goes through: how a path meets, crosses and leaves the interiors of clear bodies.
#pragma once

#include "core/integrator/layer_split.h"
#include "core/integrator/path_state.h"
#include "core/material/disney_transmissive_bsdf.h"
#include "core/sampling/pixel_sampler.h"

namespace alabaster {

/// The result of meet_boundary().
enum class Meeting {
  boundary,  // vertex->boundary is set
  nothing,   // an interior of higher priority is on both sides: the path's ray goes on behind the surface
  other,     // vertex->triangle is on a surface that takes the place of this one; the rest of the vertex is not
};

/// Meets the surface of a material that transmits. Where it disperses light, a path of several channels keeps one,
/// which `u` chooses; *u is a fresh number afterwards. Surfaces of other closed clear bodies that lie on this one are
/// crossed with it (PathVertex::past), and if light walks in none of them, the one of the highest priority takes the
/// place of all. An opaque surface there comes before any: behind both the path would be in the opaque body. Else
/// chance would decide which of them a ray finds.
Meeting meet_boundary(const PathContext& context, const PixelSampler& sampler, PathVertex* vertex, PathState* path,
                      float* u);

/// Samples direct light on both sides, then a lobe and the path's next ray. Empty: the path ends. Lobe::subsurface: it
/// goes on below the surface, weighed for the entry. `split`, unless null, takes the layers at the first vertex.
///
/// Shadow rays end at clear surfaces too: light finds its way through them by sampled lobes alone.
std::optional<Lobe> scatter_at_boundary(const PathContext& context, const PathVertex& vertex,
                                        const VertexNumbers& numbers, PathState* path, LayerSplit* split);

/// The kind of ray that seeks interiors: culled surfaces are not there for camera rays.
enum class Seeker { camera, path };

/// The interiors that the ray's origin lies in: all whose surface the ray leaves without having entered, however far
/// away (its tmax does not count). Traces a ray through the scene, whose segments count as camera or bounce rays.
Interiors interiors_at(const PathContext& context, Ray ray, Seeker seeker);

}  // namespace alabaster
