// The subsurface lobe of a path: it enters a body at a vertex and continues where the light leaves the body.
#pragma once

#include "core/integrator/path_state.h"

namespace alabaster {

/// A vertex seen from below. All paths that go on from it through its medium share one.
class VertexBelow {
 public:
  /// `within`: the path's ray came to the vertex through the medium, and the walk starts where the ray did; never so
  /// for diffusion. Keeps a reference to `vertex`.
  VertexBelow(const PathVertex& vertex, const IntegratorSettings& settings, bool within);
  VertexBelow(const VertexBelow&) = delete;
  VertexBelow& operator=(const VertexBelow&) = delete;

  const PathVertex& vertex;
  const bool within;
  const WalkMedium& medium() const { return *medium_; }

 private:
  std::optional<WalkMedium> made_;
  const WalkMedium* medium_;
};

/// Chiang, Kutz, Burley 2016, section 4: the view-dependent term weighs the entry (already in the path's throughput),
/// the light-dependent term the exit, for light sampling and for the continued path alike. Adds the light that meets
/// the exit, and sends the path on from there. False: the path ends. For every mode but lambert.
template <SubsurfaceMode kMode>
bool scatter_below_surface(const PathContext& context, const PixelSampler& sampler, const VertexBelow& vertex,
                           PathState* path);

/// Scatter distances too small for walks to resolve at the vertex become zero: Lambert, in that channel.
void drop_unresolved_distances(PathVertex* vertex);

/// True if the path's ray met the vertex from within its medium: on the inner side of a closed shell, whichever way the
/// mesh winds. A camera may stand in there, and bodies may overlap that do not scatter as one.
bool is_within_medium(const PathVertex& vertex, const PathState& path);

}  // namespace alabaster
