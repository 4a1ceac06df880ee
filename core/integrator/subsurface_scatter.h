// The subsurface lobe of a path: it enters a body at a vertex and continues where the light leaves the body.
#pragma once

#include "core/integrator/path_state.h"

namespace alabaster {

/// An exit at the vertex itself. The walk's twin in a half-space takes away what it brings out in this light, and its
/// expectation has been added: a control variate (core/subsurface/random_walk.md).
struct FlatExit {
  Rgb light{0.0f};               // that the exit lobe sends on there, of throughput one
  std::array<float, 4> numbers;  // that sampled it: exits are lit with the same, so that their light differs little
  /// Those of a constant dome's direction, where it gives most light: paths go on that way, and meet it if it was met.
  std::optional<Vec2f> onward = {};
};

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
  /// Where walks have twins: never for entries from within, nor where scattering has a preferred direction.
  std::optional<FlatExit> flat;

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

/// True where walks have twins in a half-space, a control variate (core/subsurface/random_walk.md).
template <SubsurfaceMode kMode>
bool has_twins(const PathContext& context, const DisneyParameters& material) {
  constexpr float kOverflows = 1e30f;  // beyond, a drawn distance may be infinite
  return kMode == SubsurfaceMode::walk && context.settings.walk.twins && material.scatter_anisotropy == 0 &&
         max_component(material.scatter_distance) < kOverflows;
}

/// Scatter distances too small for walks to resolve at the vertex become zero: Lambert, in that channel.
void drop_unresolved_distances(PathVertex* vertex);

/// True if the path's ray met the vertex from within its medium: on the inner side of a closed shell, whichever way the
/// mesh winds. A camera may stand in there, and bodies may overlap that do not scatter as one.
bool is_within_medium(const PathContext& context, const PathVertex& vertex, const PathState& path);

/// `*hit`: the surface that the path's ray has met. A ray in a medium that light walks in ignores clear bodies of a
/// lower rank (rank_clear_bodies()), as walks do: `*hit` becomes the wall of the medium. Clear bodies of a higher rank
/// are seen by rays that come in straight, and not by walks.
void find_own_wall(const PathContext& context, const PathState& path, TriangleHit* hit);

}  // namespace alabaster
