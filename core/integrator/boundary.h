// Surfaces that light goes through: how a path meets, crosses and leaves the interiors of clear bodies.
#pragma once

#include "core/integrator/layer_split.h"
#include "core/integrator/path_state.h"
#include "core/material/disney_transmissive_bsdf.h"

namespace alabaster {

/// False if the surface is not there, because an interior of higher priority is on both sides: the path's ray is sent
/// on behind it, and knows that it entered or left. Sets vertex->boundary. For materials that transmit. Where they
/// disperse light, a path of several channels keeps one, which `u` chooses; *u is a fresh number afterwards.
/// Surfaces of other closed clear bodies that lie on this one are crossed with it (PathVertex::past).
bool meet_boundary(const PathContext& context, PathVertex* vertex, PathState* path, float* u);

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
