// The state that a path carries from vertex to vertex. leave(), pass() and enter() set its next segment.
#pragma once

#include <limits>
#include <vector>

#include "core/integrator/media.h"
#include "core/integrator/path_integrator.h"
#include "core/material/disney_layers.h"
#include "core/subsurface/entry_exit.h"

namespace alabaster {

struct ScatterSample;
struct Vertex;
class VertexBsdf;

/// The width of the bundle of paths that one path stands for where it meets a surface: from the camera all paths of its
/// pixel, after a lobe a solid angle 1/pdf about the sampled direction (as in path differentials, Suykens and Willems
/// 2001). Kept where textures or gloss are filtered.
struct Footprint {
  PixelCone cone;

  void travel(float distance) { cone.width += cone.spread * distance; }
  /// GGX of this alpha reflects into 4 pi alpha^2, the reciprocal of its largest density: into the solid angle of the
  /// bundle. A narrower lobe meets a light by chance.
  float least_alpha() const { return std::min(1.0f, cone.spread * (0.5f / std::sqrt(kPi))); }
  void scatter(float pdf) {
    cone.spread = std::sqrt(cone.spread * cone.spread + (pdf > 0 ? std::min(1 / pdf, kTwoPi) : kTwoPi));
  }
};

/// The layer of a path's light. The first vertex that scatters decides it: by lobes, or by a walk. A direction is
/// sampled with the f of all lobes together, so light that comes back along it belongs to specular and diffuse by their
/// shares of that f, per channel: the estimate of each is then the one that its own f would give, unbiased, and the
/// layers add up to the path.
///
/// Light is direct where it comes straight from a light: along a shadow ray from the vertex that decided, or from the
/// walk's exit, along the ray from there, and where a walk that decided meets it. Clear sheets that a shadow ray passes
/// are no vertices on its way.
struct Layer {
  enum class Kind { seen, local, below };
  Kind kind = Kind::seen;
  Rgb specular{0.0f};          // local: the share of f
  bool beyond = false;         // local: the light came through the surface
  uint32_t events = 0;         // below: of scattering in the walk
  uint32_t legs = 0;           // rays and walks since it was decided
  bool through_clear = false;  // local: the path has passed clear walls alone, and its first walk decides again
  bool is_new = false;         // local: the path's ray left the vertex that decided

  void add(const Rgb& light, bool direct, LightLayers* layers) const {
    using L = LightLayers;
    switch (kind) {
      case Kind::seen:
        (*layers)[L::kSeen] += light;
        break;
      case Kind::local:
        add_local(light - light * specular, light * specular, direct, layers);
        break;
      case Kind::below:
        (*layers)[events == 0   ? direct ? L::kDirectUnscattered : L::kIndirectUnscattered
                  : events == 1 ? direct ? L::kDirectSingle : L::kIndirectSingle
                  : direct      ? L::kDirectMultiple
                                : L::kIndirectMultiple] += light;
    }
  }
  void add_local(const Rgb& of_diffuse, const Rgb& of_specular, bool direct, LightLayers* layers) const {
    using L = LightLayers;
    (*layers)[direct ? L::kDirectDiffuse : L::kIndirectDiffuse] += of_diffuse;
    (*layers)[beyond ? L::kTransmission : direct ? L::kDirectSpecular : L::kIndirectSpecular] += of_specular;
  }
};

/// A walk through a body, which the path's next segment may be in place of a ray.
struct Walk {
  Vertex* entry = nullptr;  // null: the segment is a ray
  float roulette = 0;       // the branch's number at the entry
};

/// What a path's stay in a body that something stands in keeps of its entry by a lobe, until it leaves by the body's
/// wall.
struct LobeEntry {
  const SubsurfaceBody* body;
  TriangleHit place;
  Vec3f normal;       // to the side that the path came from
  MediumStack media;  // there
  DisneyLayers::Entered layers;
  float weight;  // subsurfaceWeight there
};

struct Path {
  Ray ray;  // the next segment, unless that is a walk; all of a path's have one time
  Walk walk;
  Rgb throughput{1.0f};
  Rgb radiance{0.0f};
  /// Density of the ray's direction, summed over the branches that went on together; 0 for the camera ray, which no
  /// light sampling competes with, and infinite after a discrete choice, with which it cannot.
  float pdf = 0;
  /// For the pdf of a light that the ray meets: the lights of the last vertex (of camera rays all), and how they were
  /// sampled there. Clear sheets that the path went straight through are no such vertices, as they do not stop shadow
  /// rays.
  const LightSet* lights = nullptr;
  LightSampleContext light_context;
  Vec3f light_origin{0, 0, 0};
  float straight = 0;  // distance from there to the ray's origin; 0: it is the ray's origin
  /// In a medium: the way along the ray from the surface that it left to its origin, which a walk has come already.
  float gap = 0;
  /// The ray meets lights with a shadow link, too: it begins where lights were sampled, or at a hidden boundary, before
  /// which those that it casts no shadow of have been met.
  bool from_vertex = false;
  const Instance* hidden_boundary = nullptr;
  /// The specular lobes' share of the f at the ray's last vertex; only where lights have scales for lobes.
  Rgb specular_share{0.0f};
  uint32_t depth = 0;      // vertices before the present one; a walk has one
  uint32_t uncounted = 0;  // of those, no bounces: sheets that it went straight through, and what stands in media
  uint32_t branches = 1;   // that leave the present vertex
  MediumStack media;       // that the ray is in
  AirPockets air;          // bodies that the ray is in, in air
  std::vector<LobeEntry> lobe_entries;  // of the media that it is in, in order
  Footprint footprint;
  Layer layer;
  LightLayers* layers = nullptr;         // take the light by layer; null: not asked for
  LightByGroup* light_groups = nullptr;  // take it by group; null: not asked for
  float branch_share = 1;                // of the light of a branch, that goes to groups
  FilmSample* features = nullptr;        // takes the denoiser's features at the next surface; null: they are not sought
  bool held_out = false;                 // the camera's ray ended at a hold-out

  /// Light that the path's ray meets, or the surface at its end.
  void add(const Rgb& light) {
    radiance += light;
    if (layers) layer.add(light, layer.legs <= 1, layers);
  }
  /// Light that its walk meets, or the wall that it leaves by.
  void add_within(const Rgb& light) {
    radiance += light;
    if (layers) layer.add(light, decided_here(), layers);
  }
  /// Light that add() and its like have got began at a light of the group.
  void add_to_group(uint32_t group, const Rgb& light) const {
    if (light_groups) [[unlikely]]
      light_groups->add(group, light * branch_share);
  }
  void add_to_groups(const LightByGroup::Planes& lights, const Rgb& factor) const {
    light_groups->add(lights, factor * branch_share);
  }
  /// True if the lobes by which the ray left decide the layers of what it meets.
  bool splits_by_lobes() const { return layers && layer.kind == Layer::Kind::local && layer.is_new; }
  /// Adds such light, by those lobes.
  void add_by_lobes(const Rgb& diffuse, const Rgb& specular) {
    radiance += diffuse + specular;
    layer.add_local(diffuse, specular, true, layers);
  }
  /// Light that walks of all numbers of scattering events bring: it counts as many.
  void add_of_walks(const Rgb& light) {
    radiance += light;
    if (layers) (walk_decides_layer() ? below(kManyEvents) : layer).add(light, walk_decides_layer(), layers);
  }
  /// Ends paths that light loses nothing on.
  static constexpr uint32_t kMostUncounted = 1u << 16;
  uint32_t bounces() const { return depth - uncounted; }
  bool may_bounce(const PathContext& context) const {
    return bounces() < context.settings.max_depth && uncounted < kMostUncounted;
  }
  /// True if the path may go straight on through the vertex as shadow rays do.
  bool may_pass_sheet(const Vertex& v) const;
  /// True where the next vertex that scatters decides the layer.
  bool seeks_layer() const { return layers && layer.kind == Layer::Kind::seen; }
  /// True where the next walk that scatters does.
  bool walk_decides_layer() const { return seeks_layer() || (layers && layer.through_clear); }
  /// True at the vertex, or in the walk, that has decided.
  bool decided_here() const { return layer.legs == 0; }
  /// The layer of a walk that decides.
  Layer below(uint32_t events) const { return {Layer::Kind::below, Rgb(0.0f), false, events}; }

  Rgb through_media(const Rgb& light, float distance) const {
    return media.empty() ? light : light * media.transmittance(distance);
  }
  /// The path has come this far along its ray.
  void travel(const PathContext& context, float distance);

  /// Branch `index` of `count`, whose light by layer goes to `its_layers`, unless null.
  Path branch(uint32_t index, uint32_t count, LightLayers* its_layers) const;
  /// Adds what a branch brought.
  void join(const Path& branch, uint32_t count);

  /// The walk in whose medium the path is has met a wall within, along the direction.
  void meet_within(const Vec3f& direction);
  /// Drops the entries of bodies whose medium the path has left, through walls that were hidden within another one.
  void forget_ended_stays(const SceneSnapshot& scene);
  /// Bounces off the vertex, or through it, by the sampled lobe.
  void leave(const PathContext& context, const Vertex& v, const VertexBsdf& bsdf, const ScatterSample& sample);
  /// Goes straight on beyond a boundary that is no vertex.
  void pass(const Vertex& boundary);
  /// Goes below the surface. The vertex at the walk's exit is the next one.
  void enter(const PathContext& context, Vertex* v, float roulette);
};

/// True in a medium that light walks in and something stands in: no ray goes straight there, and no light is sampled
/// into it or through it.
inline bool is_cloudy(const PathContext& context, const MediumStack& media) {
  if (media.empty()) [[likely]]
    return false;
  return media.current()->occupied && context.mode() == SubsurfaceMode::walk;
}

inline bool keeps_footprints(const PathContext& context) {
  return context.settings.texture_filter > 0 || context.settings.glossy_filter > 0;
}

/// False: the path ends here. Unbiased: survivors carry the weight of the ended.
bool survives_roulette(const PathContext& context, float u, Path* path);

/// part / all per channel; 0 where all is 0.
inline Rgb share_of(const Rgb& part, const Rgb& all) {
  Rgb share;
  for (int c = 0; c < 3; ++c) share[c] = all[c] > 0 ? part[c] / all[c] : 0;
  return share;
}

}  // namespace alabaster
