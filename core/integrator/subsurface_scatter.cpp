#include "core/integrator/subsurface_scatter.h"

#include "core/diagnostics/check.h"
#include "core/integrator/interface.h"
#include "core/integrator/path_record.h"
#include "core/integrator/see_through.h"
#include "core/integrator/shading_normal.h"
#include "core/scene/clear_bodies.h"
#include "core/subsurface/body.h"
#include "core/subsurface/normalized_diffusion.h"
#include "core/subsurface/random_walk.h"

namespace alabaster {
namespace {

bool is_wall_of(const Interior& medium, const Instance& around, const TriangleHit& hit, const Instance& met) {
  return hit.instance == medium.instance || (around.body && around.body->is_union() && met.body == around.body);
}

bool is_clear_wall(const Instance& instance, const TriangleHit& hit) {
  return instance.material(hit.triangle).constants.spec_trans > 0;
}

/// The surfaces of the body that an interior belongs to.
class OwnWalls final : public HitFilter {
 public:
  OwnWalls(const SceneSnapshot& scene, const Interior& medium)
      : scene_(scene), medium_(medium), around_(scene.instance(medium.instance)) {}
  bool stops(const TriangleHit& hit) const noexcept override {
    return is_wall_of(medium_, around_, hit, scene_.instance(hit.instance));
  }

 private:
  const SceneSnapshot& scene_;
  const Interior& medium_;
  const Instance& around_;
};

/// The media on the outer side of an exit. The walk crosses no surface of the clear bodies that touch its own body,
/// so they are found by a ray. The inside of an open surface cannot be found so: its interior stays as at the entry.
MediumStack media_beyond(const PathContext& context, const SubsurfaceExit& exit, const SubsurfaceBody& body,
                         const Path& path) {
  MediumStack beyond;
  const auto enter_those = [&](const MediumStack& all, bool closed) {
    for (uint32_t i = 0; i < all.size(); ++i)
      if (context.scene.instance(all[i].instance).prototype->mesh.closed == closed) beyond.enter(all[i]);
  };
  enter_those(path.media, false);
  if (!body.touched.empty()) {
    const Instance& instance = context.scene.instance(exit.hit.instance);
    std::optional<Placement> moved;
    const Placement& placement = instance.at(exit.hit, &moved);
    const SurfacePoint hit =
        on_side(surface_point(instance.prototype->mesh, exit.hit, placement.object_to_world, placement.world_to_object),
                exit.direction);
    const Ray ray{offset_point(hit.p, hit.ng, hit.offset), hit.ng, std::numeric_limits<float>::infinity(),
                  exit.hit.time};
    if (body.touched.contains(ray.org)) enter_those(interiors_at(context, ray, Seeker::path), true);
  }
  for (uint32_t i = 0; i < path.air.size(); ++i) {
    const SubsurfaceBody* const pocket = context.scene.instance(path.air[i]).body;
    if (pocket && pocket->is_union())
      for (const auto& member : pocket->members) beyond.leave(member.instance);
    else
      beyond.leave(path.air[i]);
  }
  for (const auto& member : body.members) beyond.leave(member.instance_of(exit.hit));
  return beyond;
}

/// A parameter of the material at an exit.
float value_at(const PathContext& context, const SubsurfaceExit& exit, float DisneyParameters::*parameter) {
  const Instance& instance = context.scene.instance(exit.hit.instance);
  const DisneyMaterial& material = instance.material(exit.hit.triangle);
  if (!material.varies(parameter)) return material.constants.*parameter;
  std::optional<Placement> moved;
  const Placement& placement = instance.at(exit.hit, &moved);
  const SurfaceHit hit = surface_on_side(instance, placement, exit.hit, exit.direction);
  return material.evaluate(instance.primvars_at(exit.hit, hit.uv)).*parameter;
}

/// True where light walks below no part of the surface, but for a clear share.
bool is_opaque_at(const PathContext& context, const SubsurfaceExit& exit, const SubsurfaceBody& body) {
  const DisneyMaterial& material = context.scene.instance(exit.hit.instance).material(exit.hit.triangle);
  return !material.scatters() ||
         (body.weighted && value_at(context, exit, &DisneyParameters::subsurface_weight) == 0) ||
         (material.constants.metallic > 0 && !(value_at(context, exit, &DisneyParameters::metallic) < 1));
}

/// The factor of a walk that leaves by the exit lobe, between parts of the surface that let different shares of light
/// below: with the weight at the entry it counts by the lesser share, so that the exchange is reciprocal, and a part of
/// the surface sends out no more than it lets in. `entered_by`: that weight; 0: the path began within.
float weight_at_exit(const PathContext& context, const SubsurfaceExit& exit, float entered_by) {
  if (!(entered_by > 0)) return 1;
  return std::min(1.0f, value_at(context, exit, &DisneyParameters::subsurface_weight) / entered_by);
}

/// True where walks meet what stands in the body: a profile does not.
bool is_occupied(const PathContext& context, const SubsurfaceBody& body) {
  return body.occupied && context.mode() == SubsurfaceMode::walk;
}

/// Sets path->media to those beyond *exit. Where the index falls from the entry to the exit, the share (low / high)^2
/// of the walks passes, and the others come out at the entry: *exit becomes it (random_walk.md, "Clear bodies that
/// touch"). For lobes at both ends; `entered`: of a path that met something within. True: it has become the entry.
bool cross_to_media(const PathContext& context, const PixelSampler& sampler, const Vertex& entry,
                    const LobeEntry* entered, Path* path, SubsurfaceExit* exit) {
  const SubsurfaceBody& body = *entry.instance->body;
  const auto u = sampler.draw(Dimension::exit_bsdf, path->depth);  // the last one chooses a clear exit
  // A walk in an occupied body knows what it has crossed, up to the wall that it leaves by. Of a union it has entered
  // another member.
  if (is_occupied(context, body) && u[3] < value_at(context, *exit, &DisneyParameters::spec_trans)) {
    for (const auto& member : body.members)
      if (member.instance != exit->hit.instance) path->media.leave(member.instance);
    return false;
  }
  const MediumStack beyond = media_beyond(context, *exit, body, *path);
  const float share = sqr(beyond.index() / (entered ? entered->media.index() : path->media.index()));
  if (share < 1 && (entered || entry.kind != Vertex::Kind::within) && u[2] >= share &&
      u[3] >= value_at(context, *exit, &DisneyParameters::spec_trans)) {
    exit->hit = entered ? entered->place : entry.triangle;
    exit->direction = entered ? entered->normal : entry.hit.ng;
    if (entered) path->media = entered->media;
    return true;
  }
  path->media = beyond;
  return false;
}

/// The layers at the entry as light along `dir` passed them.
DisneyLayers::Entered layers_entered(const Vertex& entry, const Vec3f& dir) {
  const bool inside = entry.side.inside && !entry.side.open;
  const auto passed = inside ? std::nullopt : DisneyLayers::of(entry.material);
  return passed ? passed->entered(entry.frame.to_local(-dir)) : DisneyLayers::Entered();
}

/// The layers over the exit, of a material that has some. `at`: the vertex there. `passed`: those at the entry. A path
/// that began within passed none: those of the exit are as if its light came from everywhere.
std::optional<ExitLayers> layers_at(const Vertex& at, const SubsurfaceExit& exit,
                                    const std::optional<DisneyLayers::Entered>& passed) {
  const DisneyMaterial& material = at.instance->material(exit.hit.triangle);
  const SurfaceHit hit = surface_on_side(*at.instance, at.placement(), exit.hit, exit.direction);
  DisneyParameters p = material.evaluate(at.instance->primvars_at(exit.hit, hit.uv));
  const auto& map = material.coat_normal_map;
  if (map || material.normal_map)
    p.coat_normal = at.frame.to_local(map ? mapped_normal(*at.instance, at.placement(), exit.hit, hit, *map) : hit.ns);
  const auto layers = DisneyLayers::of(p);
  if (!layers) return std::nullopt;
  return ExitLayers{*layers, passed ? *passed : layers->from_within()};
}

/// What stands in the body that a walk goes through.
class ContentsOfScene final : public WalkContents {
 public:
  ContentsOfScene(const PathContext& context, const PixelSampler& sampler, const Rgb& scale, Path* path)
      : context_(context), scale_(scale), path_(*path), rng_(sampler.stream(Dimension::opacity, path->depth)) {}

  bool is_opaque(const TriangleHit& hit) const override {
    return !context_.scene.instance(hit.instance).material(hit.triangle).scatters();
  }
  std::optional<Vec3f> beyond(const TriangleHit& hit, const Vec3f& direction) override {
    const float coverage = coverage_at(context_.scene, direction, hit, &path_.media);
    if (coverage >= 1 || rng_.uniform() < coverage) return std::nullopt;
    const Instance& instance = context_.scene.instance(hit.instance);
    std::optional<Placement> moved;
    const Placement& at = instance.at(hit, &moved);
    const SurfacePoint s =
        on_side(surface_point(instance.prototype->mesh, hit, at.object_to_world, at.world_to_object), -direction);
    return far_side_of(s);
  }

  void meet_lights(const Ray& segment, uint32_t events, const std::function<ChannelValues(double)>& passing) override {
    const auto passed = [&](float distance) {
      const ChannelValues t = passing(distance);
      return Rgb(float(t[0]), float(t[1]), float(t[2])) * scale_;
    };
    const LightSet& lights = *path_.lights;
    // What has not scattered is seen as it is, or by the lobes that the path left by.
    const LobeShares diffuse, left{Rgb(1.0f) - path_.specular_share, path_.specular_share};
    const LobeShares* const shares = events > 0 ? &diffuse : path_.depth > 0 ? &left : nullptr;
    Rgb met(0.0f), linked(0.0f);
    const auto add_to = [&](Rgb* sum) {
      return [&lights, this, sum](size_t light, const Rgb& term) {
        *sum += term;
        path_.add_to_group(lights.group_of(light), term);
      };
    };
    lights.each_emitted(
        segment, false, false, {}, [&](float, float distance) { return passed(distance); }, 0, shares, add_to(&met));
    if (lights.has_shadow_links())
      lights.each_emitted_with_links(
          segment, {}, [](float) { return 1.0f; },
          [&](uint32_t, float distance) { return distance <= segment.tmax ? passed(distance) : Rgb(0.0f); }, shares,
          add_to(&linked));
    met += linked;
    if (is_black(met)) return;
    const Layer before = path_.layer;
    if (path_.seeks_layer() || (path_.walk_decides_layer() && events > 0)) path_.layer = path_.below(events);
    path_.add_within(met);
    path_.layer = before;
    if (context_.record) context_.record->meet_light(met);
  }

 private:
  const PathContext& context_;
  const Rgb scale_;
  Path& path_;
  Rng rng_;
};

/// The entry by a lobe of the path's stay in the body, which ends. Empty: it came in through a clear wall, began there,
/// or has met nothing within.
std::optional<LobeEntry> take_lobe_entry(const SubsurfaceBody& body, Path* path) {
  auto& all = path->lobe_entries;
  const auto found = std::find_if(all.rbegin(), all.rend(), [&](const LobeEntry& e) { return e.body == &body; });
  if (found == all.rend()) return std::nullopt;
  const LobeEntry entered = *found;
  all.erase(std::next(found).base());
  return entered;
}

/// The stay in the body begins, by the lobe at the entry.
LobeEntry lobe_entry_of(const Vertex& entry, const Path& path) {
  return {entry.instance->body,
          entry.triangle,
          entry.hit.ng,
          path.media,
          layers_entered(entry, path.ray.dir),
          entry.material.subsurface_weight};
}

/// A path goes into the medium: that counts where it meets something there. Returns the factor of the throughput.
Rgb enter_medium(const Vertex& entry, MediumStack* media) {
  const Rgb indices = media->indices();
  Interior interior = interior_of(entry);
  interior.occupied = true;
  if (!entry.material.transmits()) interior.priority = ~uint64_t(0);  // it is behind an opaque wall
  media->enter(interior);
  return index_factor(indices, media->indices());
}

/// By a lobe: that compensates for the albedo of the exit lobe, which no light within passes.
Rgb enter_by_lobe(const Vertex& entry, MediumStack* media) {
  return enter_medium(entry, media) * kMeanDiffuseTransmittance;
}

/// The path is in the medium now, if it was not before: it has entered by a lobe, or began behind an opaque wall.
void enter_interior(const PathContext& context, const Vertex& entry, Path* path) {
  if (entry.kind == Vertex::Kind::within) {
    if (path->media.contains(entry.triangle.instance) || is_in_union(context.scene, path->media, *entry.instance))
      return;
    path->throughput *= enter_medium(entry, &path->media);
    return;
  }
  path->lobe_entries.push_back(lobe_entry_of(entry, *path));
  path->throughput *= enter_by_lobe(entry, &path->media);
}

/// The throughput of a walk's lights over the walk's own, which is relative to the largest channel.
Rgb scale_within(const Vertex& entry, const Path& path) {
  const Rgb scale(max_component(path.throughput));
  if (entry.kind == Vertex::Kind::within) return scale;
  MediumStack media = path.media;
  return scale * enter_by_lobe(entry, &media);
}

/// The walls of a body, or what is opaque and not of it.
class WallsOrCovers final : public HitFilter {
 public:
  WallsOrCovers(const SceneSnapshot& scene, const SubsurfaceBody& body, bool walls)
      : scene_(scene), body_(body), walls_(walls) {}
  bool stops(const TriangleHit& hit) const noexcept override {
    const Instance& met = scene_.instance(hit.instance);
    return walls_ ? met.body == &body_ : met.body != &body_ && !met.material(hit.triangle).transmits();
  }

 private:
  const SceneSnapshot& scene_;
  const SubsurfaceBody& body_;
  const bool walls_;
};

/// Where walls lie on each other the walk may have met either of them: *exit becomes the body's own before another
/// clear one, and what is opaque before its own clear one.
void choose_wall(const PathContext& context, const SubsurfaceBody& body, WalkContents* contents, SubsurfaceExit* exit) {
  const Instance& instance = context.scene.instance(exit->hit.instance);
  const DisneyMaterial& material = instance.material(exit->hit.triangle);
  if (!material.transmits() || material.constants.thin) return;
  std::optional<Placement> moved;
  const Placement& at = instance.at(exit->hit, &moved);
  const SurfacePoint s = on_side(
      surface_point(instance.prototype->mesh, exit->hit, at.object_to_world, at.world_to_object), -exit->direction);
  if (!context.scene.clear_meetings.contains(s.p)) return;
  const Vec3f near = offset_point(s.p, s.ng, s.offset), far = far_side_of(s);
  const Ray across{near, -s.ng, length(far - near), exit->hit.time};
  ++context.counters.bounce_rays;
  TriangleHit other;
  const WallsOrCovers sought(context.scene, body, exit->is_content);
  if (!context.scene.top->intersect(across, &other, &sought)) return;
  if (exit->is_content ? !body.leaves(context.scene.instance(other.instance).member, other, exit->direction)
                       : contents->beyond(other, exit->direction).has_value())
    return;
  exit->hit = other;
  exit->is_content = !exit->is_content;
}

}  // namespace

Exit find_exit(const PathContext& context, const PixelSampler& sampler, Path* path, Vertex* v) {
  PathRecord* const record = context.record;
  Vertex& entry = *path->walk.entry;  // it may be *v, which is written last
  const std::optional<ControlVariate>& control = entry.control;
  const bool is_within = entry.kind == Vertex::Kind::within;
  const SubsurfaceBody& body = *entry.instance->body;
  path->walk.entry = nullptr;

  // Walk. Where no walk is followed, the twin has its expectation.
  SubsurfaceEntry start{entry.triangle, entry.instance->member, entry.hit,
                        entry.frame.n,  path->throughput,       entry.medium};
  if (is_within) start.within = path->ray, start.gap = path->gap;
  const bool has_twin = control && !is_black(control->light);
  if (has_twin) DCHECK(entry.medium->medium.albedo == entry.material.medium_albedo());
  Rgb twin = has_twin ? path->throughput * control->albedo : Rgb(0.0f);
  SubsurfaceNumbers numbers(sampler, Dimension::subsurface, path->depth);
  std::optional<ContentsOfScene> contents;
  if (is_occupied(context, body)) [[unlikely]]
    contents.emplace(context, sampler, scale_within(entry, *path), path);
  const RandomWalk walk{context.settings.walk, record ? record->walk() : nullptr, has_twin ? &twin : nullptr,
                        contents ? &*contents : nullptr};
  auto exit = context.mode() == SubsurfaceMode::diffusion
                  ? NormalizedDiffusion{}.carry(body, start, numbers, context.counters)
                  : walk.carry(body, start, numbers, context.counters);
  if (has_twin) {
    const Rgb taken = twin * control->light * -1.0f;
    path->add_of_walks(taken);
    if (control->by_group) [[unlikely]]
      path->add_to_groups(*control->by_group, twin * -1.0f);
    if (record) record->twin_leaves(taken);
  }
  if (!exit) {
    if (record) record->end("the light did not leave the body");
    return Exit::none;
  }
  const bool decides = path->seeks_layer() || (path->walk_decides_layer() && exit->events > 0);
  if (decides)
    path->layer = path->below(exit->events);
  else
    ++path->layer.legs;
  path->throughput = exit->throughput;

  // Meet what stands in the body, or an opaque face of its own, in its medium. A profile ends there.
  if (contents) [[unlikely]]
    choose_wall(context, body, &*contents, &*exit);
  if (exit->is_content || is_opaque_at(context, *exit, body)) [[unlikely]] {
    if (context.mode() == SubsurfaceMode::diffusion) {
      if (record) record->end("the light met an opaque surface from below");
      return Exit::none;
    }
    enter_interior(context, entry, path);
    path->meet_within(exit->direction);
    v->triangle = exit->hit;
    return Exit::within;
  }

  // Find the media beyond the exit.
  const std::optional<LobeEntry> entered = take_lobe_entry(body, path);
  const Rgb index = path->media.indices();
  const bool may_cross = !path->media.empty() || !body.touched.empty();
  const bool is_back =
      may_cross && cross_to_media(context, sampler, entry, entered ? &*entered : nullptr, path, &*exit);
  path->forget_ended_stays(context.scene);                 // of media that end with this one
  if (body.is_union() && !path->air.empty()) [[unlikely]]  // the walk left the union's medium
    path->air.leave(body.members.front().instance);
  const Instance& instance = context.scene.instance(exit->hit.instance);
  const DisneyMaterial& material = instance.material(exit->hit.triangle);

  // Leave by the clear share of an interface: a vertex that is seen from inside. What it reflects walks on in the body.
  // A path that came by an entry lobe is multiplied by the albedo of the exit lobe here, as the next walk has no entry,
  // unless it has been where it met something within.
  // A profile does not know from where the light comes to the interface.
  if (material.constants.spec_trans > 0 && !is_back && context.mode() != SubsurfaceMode::diffusion) [[unlikely]] {
    const VertexSamples u{sampler.draw(Dimension::exit_light, path->depth),
                          sampler.draw(Dimension::exit_bsdf, path->depth), path->walk.roulette};
    Vertex clear;
    const Ray arriving{path->ray.org, exit->direction, path->ray.tmax, path->ray.time};
    evaluate_surface(context, arriving, exit->hit, 0, &clear);
    if (u.bsdf[3] < clear.material.spec_trans) {
      clear.kind = Vertex::Kind::interface;
      clear.u = u;
      clear.material.metallic = clear.material.diff_trans = 0;
      clear.material.spec_trans = 1;
      const auto stay = is_within || !is_occupied(context, body) ? entered : std::optional(lobe_entry_of(entry, *path));
      path->ray = arriving;
      if (!is_within) path->throughput *= kMeanDiffuseTransmittance;
      if (record) record->leave_body(*clear.instance, exit->hit, clear.hit, path->throughput);
      const Meeting met = resolve_interface(context, sampler, &clear, path);
      path->throughput *= index_factor(index, path->media.indices());
      if (met == Meeting::replaced) {  // the path is still in the body
        if (stay) path->lobe_entries.push_back(*stay);
        path->meet_within(exit->direction);
        v->triangle = clear.triangle;
        return Exit::within;
      }
      *v = clear;
      if (met == Meeting::visible) {
        const Rgb glow = path->throughput * clear.material.emission;
        path->add_within(glow);
        path->add_to_group(v->instance->light_group, glow);
        if (record) record->meet_light(glow);
        return Exit::vertex;
      }
      path->forget_ended_stays(context.scene);
      ++path->layer.legs;
      return Exit::passes;
    }
  }
  if (may_cross) path->throughput *= index_factor(index, path->media.indices());

  // Leave by the exit lobe: the lobes at the entry compensate for its albedo. In the medium it is normalised instead.
  if (is_within) path->throughput *= 1 / kMeanDiffuseTransmittance;
  if (body.weighted) [[unlikely]] {
    const float of_entry = is_within ? 0 : entry.material.subsurface_weight;
    path->throughput *= weight_at_exit(context, *exit, entered ? entered->weight : of_entry);
  }
  const bool has_layers = material.constants.has_dimming_layers();
  std::optional<DisneyLayers::Entered> passed;
  if (has_layers && (!is_within || entered)) [[unlikely]]
    passed = entered ? entered->layers : layers_entered(entry, path->ray.dir);
  v->kind = Vertex::Kind::exit;
  v->instance = &instance;
  v->triangle = exit->hit;
  // Draw the random numbers while the triangle comes from memory.
  const Mesh& mesh = instance.prototype->mesh;
  v->u.light = control ? control->light_numbers : sampler.draw(Dimension::exit_light, path->depth);
  prefetch_corners(mesh, exit->hit.triangle, Attributes::normals);
  if (control && control->dome_sample)
    v->u.bsdf = {control->dome_sample->x, control->dome_sample->y};
  else
    v->u.bsdf = sampler.draw(Dimension::exit_bsdf, path->depth);
  v->u.roulette = path->walk.roulette;
  v->control.reset();
  v->moved.reset();
  const Placement& placement = instance.at(exit->hit, &v->moved);
  static_cast<SurfacePoint&>(v->hit) =
      on_side(surface_point(mesh, exit->hit, placement.object_to_world, placement.world_to_object), exit->direction);
  v->set_near_origins(v->hit.ns);
  v->is_mapped = material.normal_map.has_value();
  const auto full_hit = [&] { return surface_on_side(instance, placement, exit->hit, exit->direction); };
  v->frame = frame_from_normal(
      v->is_mapped ? mapped_normal(instance, placement, exit->hit, full_hit(), *material.normal_map) : v->hit.ns);
  v->exit_layers.reset();
  if (has_layers) [[unlikely]] {
    v->exit_layers = layers_at(*v, *exit, passed);
    if (v->exit_layers) path->throughput *= v->exit_layers->layers.coat.passage;
  }
  if (record) record->leave_body(instance, exit->hit, full_hit(), path->throughput);
  return Exit::vertex;
}

bool is_wall_of_union(const PathContext& context, const Path& path, const TriangleHit& hit) {
  const Interior* const medium = path.media.current();
  if (!medium || !medium->scatters) return false;
  const SubsurfaceBody* const body = context.scene.instance(medium->instance).body;
  return body && body->is_union() && context.scene.instance(hit.instance).body == body;
}

void find_members(const PathContext& context, const TriangleHit& met, Path* path) {
  const SceneSnapshot& scene = context.scene;
  const Interior* const around = path->media.current();
  const SubsurfaceBody* const body = around ? scene.instance(around->instance).body : nullptr;
  const Instance& instance = scene.instance(met.instance);
  const DisneyMaterial& material = instance.material(met.triangle);
  if (!body || !body->is_union() || instance.body == body || !material.transmits() || material.constants.thin) return;
  std::optional<Placement> moved;
  const Placement& at = instance.at(met, &moved);
  const SurfacePoint s =
      on_side(surface_point(instance.prototype->mesh, met, at.object_to_world, at.world_to_object), -path->ray.dir);
  const Ray ray{offset_point(s.p, s.ng, s.offset), s.ng, std::numeric_limits<float>::infinity(), met.time};
  const MediumStack all = interiors_at(context, ray, Seeker::path);
  MediumStack others;
  for (uint32_t i = 0; i < path->media.size(); ++i)
    if (scene.instance(path->media[i].instance).body != body) others.enter(path->media[i]);
  const uint32_t outside = others.size();
  for (uint32_t i = 0; i < all.size(); ++i)
    if (scene.instance(all[i].instance).body == body) others.enter(all[i]);
  if (others.size() > outside) path->media = others;  // members with opaque walls are not found
}

bool find_wall_ahead(const PathContext& context, const Path& path, TriangleHit* hit) {
  const OwnWalls walls(context.scene, *path.media.current());
  ++context.counters.bounce_rays;
  TriangleHit ahead;
  if (context.scene.top->intersect(path.ray, &ahead, &walls)) return *hit = ahead, true;
  // Behind an open mesh there may be none. The wall that the path comes from tells the medium as well.
  return path.depth > 0 && walls.stops(*hit);
}

void make_vertex_within(const PathContext& context, const Path& path, Vertex* v) {
  make_vertex(context, v->triangle, path, v);
  v->material.emission = Rgb(0.0f);
  set_within(v);
}

void set_within(Vertex* v) {
  v->kind = Vertex::Kind::within;
  if (is_clear_wall(*v->instance, v->triangle)) v->material.emission = Rgb(0.0f);  // is_lit_by_walks()
  if (v->has_medium()) return;
  for (const DisneyMaterial* material : v->instance->materials)
    if (material->scatters()) {
      material->evaluate(v->instance->primvars_at(v->triangle, v->hit.uv), &v->material);
      v->material.emission = Rgb(0.0f);
      drop_unresolved_distances(v);
      return;
    }
}

bool is_lit_by_walks(const PathContext& context, const MediumStack& media, const TriangleHit& hit) {
  const Interior& medium = *media.current();
  const Instance& met = context.scene.instance(hit.instance);
  if (!medium.scatters || context.mode() != SubsurfaceMode::walk || !is_clear_wall(met, hit)) return false;
  if (!met.body || !is_wall_of(medium, context.scene.instance(medium.instance), hit, met)) return false;
  const uint8_t flags = met.body->members[met.member].shells->flags(hit.triangle);
  return !(flags & (MeshShells::kOpen | MeshShells::kInner));
}

void find_own_wall(const PathContext& context, const Path& path, TriangleHit* hit) {
  const Interior* const medium = path.media.current();
  if (!medium || !medium->scatters || hit->instance == medium->instance) return;
  const Instance& met = context.scene.instance(hit->instance);
  const Instance& around = context.scene.instance(medium->instance);
  const DisneyMaterial& material = met.material(hit->triangle);
  if (!material.transmits() || material.constants.thin || is_wall_of(*medium, around, *hit, met)) return;
  std::optional<Placement> moved;
  const Placement& placement = met.at(*hit, &moved);
  if (interior_priority(met, placement, material.constants.priority, hit->instance) > medium->priority) return;
  const OwnWalls walls(context.scene, *medium);
  ++context.counters.bounce_rays;
  TriangleHit wall;
  if (context.scene.top->intersect(path.ray, &wall, &walls)) *hit = wall;
}

void drop_unresolved_distances(Vertex* v) {
  const float depth = depth_below_surface(v->hit, v->placement().object_to_world);
  Rgb& distance = v->material.scatter_distance;
  // Behind a clear surface there is no Lambert's law: such a channel is as dense as walks resolve.
  const bool clear = v->material.spec_trans > 0;
  const float least = least_resolved(depth);
  for (int c = 0; c < 3; ++c)
    if (!is_resolved(distance[c], depth)) distance[c] = clear ? least : 0;
}

namespace {

// An opaque face of a mesh that scatters. Those that are seen in the air of a body are thin.
bool is_opaque_face(const Vertex& v) {
  return !v.material.thin && !v.material.transmits() && !v.instance->material(v.triangle.triangle).scatters();
}

}  // namespace

bool is_within_medium(const PathContext& context, const Vertex& v, const Path& path) {
  const SubsurfaceBody* body = v.instance->body;
  if (!body) return false;
  const bool scatters = v.has_medium() && v.material.metallic != 1;
  if (!scatters && !is_opaque_face(v)) return false;
  if (body->is_union()) [[unlikely]] {
    // The first hit of a path may be where its ray enters the union.
    if (path.depth == 0) return body->contains(path.ray);
    if (is_in_union(context.scene, path.media, *v.instance)) return true;
  }
  const uint8_t flags = body->members[v.instance->member].shells->flags(v.triangle.triangle);
  return !(flags & (MeshShells::kOpen | MeshShells::kInner)) &&
         body->leaves(v.instance->member, v.triangle, path.ray.dir);
}

}  // namespace alabaster
