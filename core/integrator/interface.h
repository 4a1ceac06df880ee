// Dielectric interfaces: how a path meets them, and the media on their sides.
#pragma once

#include "core/integrator/vertex.h"
#include "core/sampling/pixel_sampler.h"

namespace alabaster {

enum class Meeting {
  visible,   // v->side and the origin of its far side are set
  hidden,    // a medium of higher priority is on both sides: the path's ray goes on behind the interface
  replaced,  // v->triangle is on a surface that takes the place of this one; the rest of the vertex is not
};

/// Meets the surface of a material that transmits. Where it disperses light, a path of several channels keeps one,
/// which v->u.bsdf[0] chooses; that is a fresh number afterwards. Surfaces of other closed clear bodies that lie on
/// this one are crossed with it (Vertex::beyond), and if light walks in none of them, the one of the highest priority
/// takes the place of all. An opaque surface there comes before any: behind both the path would be in the opaque body.
/// Else chance would decide which of them a ray finds.
Meeting resolve_interface(const PathContext& context, const PixelSampler& sampler, Vertex* v, Path* path);

/// True if `ray`, which arrives in `media`, would meet a boundary there that a medium of higher priority hides.
/// Surfaces that lie on it do not count.
bool is_hidden_boundary(const PathContext& context, const Ray& ray, const TriangleHit& hit, const MediumStack& media);

/// The media on the far side of a visible interface. `media`: on the near side.
MediumStack media_past(const Vertex& v, MediumStack media);
/// Factor of what passes, beside the lobes: those of a clear share have it.
Rgb passing_factor(const Vertex& v, const MediumStack& from, const MediumStack& to);

/// The interior of the body whose surface the vertex is on.
Interior interior_of(const Vertex& v);
/// True if the vertex is seen from its body's interior. `media`: that the ray arrives in.
bool is_seen_from_inside(const Vertex& v, const MediumStack& media);
void cross_interface(const Vertex& v, bool inside, MediumStack* media);

/// The kind of ray that seeks interiors: culled surfaces are not there for camera rays.
enum class Seeker { camera, path };

/// The interiors that the ray's origin lies in: all whose surface the ray leaves without having entered, however far
/// away (its tmax does not count). Traces a ray through the scene, whose segments count as camera or bounce rays.
MediumStack interiors_at(const PathContext& context, Ray ray, Seeker seeker);

}  // namespace alabaster
