// The walk of a path through a body, from the vertex where it enters to the vertex at its exit.
#pragma once

#include "core/integrator/vertex.h"
#include "core/sampling/pixel_sampler.h"

namespace alabaster {

enum class Exit {
  vertex,  // the walk left the body at the vertex
  within,  // it met what stands in the body, at v->triangle; the rest of the vertex is not made yet
  passes,  // it left by an interface that is not there: the path's next segment is a ray from there
  none,    // the path has ended
};

/// Follows the path's walk to its exit. Chiang, Kutz, Burley 2016, section 4: the view-dependent term weighs the entry
/// (already in the path's throughput), the light-dependent term is the exit lobe of the vertex. `v` may be the walk's
/// entry. Adds what the control variate takes away, and lights that the walk meets. For every mode but
/// lambert.
Exit find_exit(const PathContext& context, const PixelSampler& sampler, Path* path, Vertex* v);

/// Scatter distances too small for walks to resolve at the vertex become zero: Lambert, in that channel. Behind a clear
/// surface they become the least that walks resolve.
void drop_unresolved_distances(Vertex* vertex);

/// True if the path's ray met the vertex from within its medium: on the inner side of a closed shell, whichever way the
/// mesh winds. A camera may stand in there, and bodies may overlap that do not scatter as one.
bool is_within_medium(const PathContext& context, const Vertex& vertex, const Path& path);

/// True if the ray of a path in the medium of a union has met a wall of it: walls between its members are not there, so
/// it is no matter which.
bool is_wall_of_union(const PathContext& context, const Path& path, const TriangleHit& hit);

/// In a union a walk knows not which members it is in: finds them where it has met a clear wall of what stands there,
/// within which their walls count.
void find_members(const PathContext& context, const TriangleHit& met, Path* path);

/// The nearest wall ahead of the path's ray, of the medium that it is in: it says which medium that is. False: there is
/// none.
bool find_wall_ahead(const PathContext& context, const Path& path, TriangleHit* hit);
/// Makes the vertex there, v->triangle, of one that is within the medium.
void make_vertex_within(const PathContext& context, const Path& path, Vertex* v);
/// The vertex is on a wall of the medium that the path came through. An opaque one has the medium of the mesh's first
/// material that scatters.
void set_within(Vertex* v);

/// True if a ray in the media would meet a clear wall of the medium that light walks in: what that emits inwards walks
/// meet where they leave by it.
bool is_lit_by_walks(const PathContext& context, const MediumStack& media, const TriangleHit& hit);

/// `*hit`: the surface that the path's ray has met. A ray in a medium that light walks in ignores clear bodies of a
/// lower rank (rank_clear_bodies()), as walks do: `*hit` becomes the wall of the medium. Clear bodies of a higher rank
/// are seen by rays that come in straight, and not by walks.
void find_own_wall(const PathContext& context, const Path& path, TriangleHit* hit);

}  // namespace alabaster
