// Next-event estimation: one direction for each sampled light, weighed against BSDF sampling by the power heuristic.
// The other half of the weight is taken where a ray meets a light (emission.h).
#pragma once

#include "core/integrator/vertex_bsdf.h"

namespace alabaster {

/// The weight of a sampled light.
struct LightWeight {
  float pdf;  // of sampling the direction, with the choice of light
  float mis;  // against BSDF sampling
};

/// Adds the light that the sampled lights send by way of the vertex, and the expectation of its control variate, which
/// takes the light of the exit lobe there.
///
/// Shadow rays go straight on through clear sheets, and end at clear solids: light finds its way through those by BSDF
/// sampling alone.
void sample_lights(const PathContext& context, const VertexBsdf& bsdf, Vertex* v, Path* path);

/// The light that a shadow catcher at the vertex gets straight from lights: as a white Lambertian surface sends it on,
/// by light sampling alone. Catchers keep light away from both sums, other meshes from `shadowed`.
void catch_shadows(const PathContext& context, const Vertex& v, const MediumStack& media, FilmSample* out);

/// True if no geometry lies between the facet and the smooth surface over it: where bodies touch, light must not slip
/// in between them.
bool reaches_smooth_surface(const PathContext& context, const Vertex& v);

}  // namespace alabaster
