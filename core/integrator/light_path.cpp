#include "core/integrator/light_path.h"

#include <algorithm>
#include <cmath>

#include "core/integrator/direct_light.h"
#include "core/integrator/path_surface.h"
#include "core/integrator/surface_light.h"

namespace alabaster {

namespace {

// Normals bend towards those who see them at a grazing angle (bend_towards). Light paths keep to directions in which
// none does, so that both ways have the same frame.
constexpr float kLeastCosine = 0.011f;

// Denser directions at the first surface are those of a narrow lobe. They find the second surface well, and a light path
// would meet the lobe by chance.
constexpr float kMostPdf = 1;

float triangle_area(const Instance& instance, uint32_t triangle) {
  const auto corners = instance.prototype->mesh.corners_at(triangle, 0);
  const Affine& map = instance.object_to_world;
  return 0.5f * length(cross(map.vector(corners[1] - corners[0]), map.vector(corners[2] - corners[0])));
}

// The point where a light path begins, on the outer side of its surface.
struct PathBegin {
  TriangleHit triangle;
  PathVertex v;
  float pdf_area;
};

std::optional<PathBegin> choose_begin(const PathContext& context, const PixelSampler& sampler) {
  // Choose a caster, and a triangle of it; all its triangles have the same chance.
  const LightPathPlan& plan = *context.light_paths;
  const auto u = sampler.draw(Dimension::light_path, 0);
  float rest = u[0];
  size_t i = 0;
  while (i + 1 < plan.casters.size() && rest >= plan.casters[i].chance) rest -= plan.casters[i++].chance;
  const auto [caster, chance] = plan.casters[i];
  const Instance& instance = context.scene.instances[caster];
  const Mesh& mesh = instance.prototype->mesh;
  const auto count = static_cast<float>(mesh.triangles.size());

  // Choose a point of the triangle.
  PathBegin begin;
  begin.triangle.instance = caster;
  begin.triangle.triangle = static_cast<uint32_t>(std::min(std::max(rest / chance, 0.0f) * count, count - 1));
  const Vec2f b = sample_uniform_triangle({u[1], u[2]});
  begin.triangle.u = b.x, begin.triangle.v = b.y;
  const auto corners = mesh.corners_at(begin.triangle.triangle, 0);
  begin.triangle.normal = cross(corners[1] - corners[0], corners[2] - corners[0]);
  const float area = triangle_area(instance, begin.triangle.triangle);
  if (!(area > 0)) return std::nullopt;
  begin.pdf_area = plan.triangle_chance[caster] / area;

  // Look at it from above.
  const SurfacePoint point = surface_point(mesh, begin.triangle, instance.object_to_world, instance.world_to_object);
  begin.v = make_vertex(context, {point.p + point.ng, -point.ng}, begin.triangle);
  if (begin.v.mapped || begin.v.material.transmits()) return std::nullopt;
  return begin;
}

// True if the path's ray ends at `what`, at about this distance.
bool ends_at(const PathContext& context, const PixelSampler& sampler, const TriangleHit& what, float distance,
             PathState* path, TriangleHit* hit) {
  if (!trace(context, sampler, *path, hit) || hit->instance != what.instance) return false;
  const bool is_near = std::abs(hit->t - distance) < 1e-4f * distance;
  if (hit->triangle != what.triangle && !is_near) return false;
  path->ray.tmax = hit->t;
  return true;
}

// Calls visit(hit) for each surface on which light along the ray may land: the first, and those behind where the
// camera's path, which comes the other way, may pass.
template <class Visit>
void for_each_landing(const PathContext& context, Ray ray, const Visit& visit) {
  const SceneSnapshot& scene = context.scene;
  while (true) {
    TriangleHit hit;
    ++context.counters.bounce_rays;
    if (!scene.top->intersect(ray, &hit)) return;
    const Instance& instance = scene.instance(hit.instance);
    std::optional<Placement> moved;
    const Placement& placement = instance.at(hit, &moved);
    const SurfacePoint point = on_side(
        surface_point(instance.prototype->mesh, hit, placement.object_to_world, placement.world_to_object), -ray.dir);
    visit(hit, point);
    if (!instance.see_through || !(coverage_at(scene, -ray.dir, hit) < 1)) return;
    ray.org = offset_point(point.p, -point.ng, point.offset);
  }
}

// A light path between its light and where it lands.
struct Reflection {
  const PathBegin& begin;
  LightSample light;
  float arrives;       // the share of the light
  Vec3f onward;        // unit
  float pdf_specular;  // of it
};

// Follows the path that the camera would take to where the light landed, and from there to where the light path began:
// everything but the densities of the light path itself is what that path would find.
template <SubsurfaceMode kMode>
std::optional<LightLanding> show_landing(const PathContext& context, const PixelSampler& sampler,
                                         const Reflection& way, const TriangleHit& landed, const SurfacePoint& at) {
  // Find where the camera sees the point.
  const auto u = sampler.draw(Dimension::film_lens, 0);
  const auto film = context.camera.film_position(at.p, {u[0], u[1]});
  if (!film) return std::nullopt;
  PathState path;
  path.ray = context.camera.generate_ray(*film, {u[0], u[1]});
  if (dot(at.ng, path.ray.dir) >= 0 || context.scene.clear_bodies.contains(path.ray.org)) return std::nullopt;
  if (keeps_footprints<kMode>(context)) path.footprint.cone = context.camera.pixel_cone(path.ray.dir);
  TriangleHit hit;
  ++context.counters.bounce_rays;
  if (!ends_at(context, sampler, landed, dot(at.p - path.ray.org, path.ray.dir), &path, &hit)) return std::nullopt;
  const PathVertex x = find_vertex<kMode>(context, hit, &path);
  if (x.material.transmits() || x.instance->holdout || is_within_medium(x, path)) return std::nullopt;

  // Go on from there to where the light path began.
  const DisneyBsdf bsdf_x(x.material, x.frame.to_local(-path.ray.dir), context.settings.energy);
  const Vec3f to_y = way.begin.v.hit.p - x.departure.flat, dir = normalize(to_y), wi = x.frame.to_local(dir);
  if (!x.departure.is_above(dir) || !x.is_above_surface(dir)) return std::nullopt;
  Rgb specular;
  const BsdfValue value = bsdf_x.evaluate(wi, &specular);
  if (is_black(value.f) || !(value.pdf > 0)) return std::nullopt;
  PathState second;
  second.depth = 1;
  second.footprint = path.footprint;
  if (keeps_footprints<kMode>(context)) second.footprint.scatter(value.pdf);
  second.go_on(x.departure.flat, dir);
  second.scatter_pdf = value.pdf * static_cast<float>(kPathsPerSample);
  second.light_path_ratio = light_path_ratio(context, x, path, second);
  ++context.counters.bounce_rays;
  if (!ends_at(context, sampler, way.begin.triangle, length(to_y), &second, &hit)) return std::nullopt;
  const PathVertex y = find_vertex<kMode>(context, hit, &second);
  if (y.material.transmits() || is_within_medium(y, second)) return std::nullopt;

  // Reflect the light there.
  const DisneyBsdf bsdf_y(y.material, y.frame.to_local(-dir), context.settings.energy);
  const Vec3f to_light = y.frame.to_local(way.light.wi);
  Rgb shine;
  bsdf_y.evaluate(to_light, &shine);
  LightLanding landing{*film};
  landing.ratio = is_black(shine) ? 0 : light_path_ratio(context, second, y, bsdf_y, way.light.wi);
  landing.share = light_path_share(landing.ratio);
  if (!(landing.share > 0)) return std::nullopt;

  // Weigh it: the light that both segments carry over the density of the light path, both over film and y.
  const float pixels = context.camera.pixels_per_area(path.ray.dir, x.hit.p) * -dot(x.departure.ng, path.ray.dir);
  const float pdf = way.begin.pdf_area * way.pdf_specular * way.light.pdf * dot(x.departure.ng, dir) *
                    static_cast<float>(context.light_paths->paths);
  const float carried = wi.z * to_light.z * -dot(y.departure.ng, dir) * way.arrives;
  const Rgb arriving = shine * way.light.radiance * (carried * pixels * landing.share / pdf);
  landing.color = value.f * arriving;
  landing.specular = specular * arriving;
  return is_finite(landing.color) ? std::optional(landing) : std::nullopt;
}

template <SubsurfaceMode kMode>
void trace_light_path(const PathContext& context, const PixelSampler& sampler, std::vector<LightLanding>* landings) {
  const auto begin = choose_begin(context, sampler);
  if (!begin) return;
  const PathVertex& v = begin->v;
  const DisneySpecular lobe = DisneySpecular::from(v.material);
  const Vec3f& ng = v.departure.ng;
  const bool walks = kMode != SubsurfaceMode::lambert && v.material.scatters();
  const LightSearch search{walks ? ConstantDomes::sampled : ConstantDomes::left_to_lobes, ng};
  const auto u = sampler.draw(Dimension::bsdf, 0);
  context.scene.lights_of(*v.instance)
      .sample_lights(v.departure.flat, {ng, ng}, sampler.draw(Dimension::light, 0), search,
                     [&](const LightSample& light) {
                       // Sample the specular lobe for a viewer at the light.
                       if (!(dot(light.wi, ng) > 0) || !(dot(light.wi, v.hit.ns) > kLeastCosine)) return;
                       const Vec3f wo = v.frame.to_local(light.wi);
                       const auto wi = lobe.sample(wo, {u[0], u[1]});
                       if (!wi) return;
                       Reflection way{*begin, light, 0, v.frame.to_world(*wi), lobe.evaluate(wo, *wi).pdf};
                       if (!(dot(way.onward, ng) > 0) || !(way.pdf_specular > 0)) return;
                       way.arrives = visibility(context, v.departure.flat, light);
                       if (!(way.arrives > 0)) return;

                       // Find where the light lands.
                       for_each_landing(context, {v.departure.flat, way.onward}, [&](const auto& hit, const auto& at) {
                         if (const auto landing = show_landing<kMode>(context, sampler, way, hit, at))
                           landings->push_back(*landing);
                       });
                     });
}

// Sums over the light paths of a caster.
struct CasterNoise {
  double camera = 0;  // relative variance that camera paths would leave in a sample of a pixel
  double light = 0;   // the same of light paths, were all of them its
};

CasterNoise noise_of(const PathContext& context, const Vec2f& size, float mean_level, uint32_t samples) {
  const LightPathTracer trace = select_light_path_tracer(context.scene.features, context.settings);
  const uint32_t seed = hash32(context.light_paths->casters.front().instance);
  CasterNoise noise;
  std::vector<LightLanding> landings;
  for (uint32_t i = 0; i < samples; ++i) {
    if (i % 64 == 0) context.settings.walk.cancel.check();
    landings.clear();
    trace(context, PixelSampler(seed, i), &landings);
    for (const LightLanding& l : landings) {
      if (!(l.film.x >= 0 && l.film.y >= 0 && l.film.x < size.x && l.film.y < size.y)) continue;
      const double shared = luminance(l.color), whole = shared / l.share;
      noise.camera += whole * whole * l.ratio;
      noise.light += shared * shared;
    }
  }
  const double scale = context.light_paths->paths / (double(samples) * size.x * size.y * mean_level * mean_level);
  return {noise.camera * scale, noise.light * scale};
}

// Surfaces at which light paths may begin.
std::vector<uint32_t> find_casters(const SceneSnapshot& scene) {
  constexpr size_t kMost = 256;
  std::vector<uint32_t> casters;
  for (uint32_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    if (instance.stands_alone() && !instance.prototype->mesh.triangles.empty()) casters.push_back(i);
    if (casters.size() > kMost) return {};  // no pilot of many is cheap
  }
  return casters;
}

}  // namespace

void LightPathPlan::spread_chances(const SceneSnapshot& scene) {
  triangle_chance.assign(scene.instances.size(), 0);
  for (const Caster& caster : casters)
    triangle_chance[caster.instance] =
        caster.chance / static_cast<float>(scene.instances[caster.instance].prototype->mesh.triangles.size());
}

float light_path_ratio(const PathContext& context, const PathVertex& v, const PathState& from, const PathState& to) {
  const Vec3f& wi = to.ray.dir;
  if (!v.departure.is_above(wi) || to.scatter_pdf > kMostPdf) return 0;
  const float pixels = context.camera.pixels_per_area(from.ray.dir, v.hit.p) * -dot(v.departure.ng, from.ray.dir);
  return static_cast<float>(context.light_paths->paths) * dot(v.departure.ng, wi) / (pixels * to.scatter_pdf);
}

float light_path_ratio(const PathContext& context, const PathState& path, const PathVertex& v, const DisneyBsdf& bsdf,
                       const Vec3f& wi) {
  const auto& chances = context.light_paths->triangle_chance;
  const uint32_t instance = v.triangle.instance;
  if (!(path.light_path_ratio > 0) || instance >= chances.size() || !(chances[instance] > 0) || v.mapped) return 0;
  const Vec3f wo = -path.ray.dir;
  if (!v.departure.is_above(wi) || !(dot(v.hit.ns, wi) > kLeastCosine) || !(dot(v.hit.ns, wo) > kLeastCosine)) return 0;
  if (is_behind(*v.instance, v.triangle, path.ray.dir)) return 0;
  const float pdf_area = chances[instance] / triangle_area(*v.instance, v.triangle.triangle);
  return path.light_path_ratio * pdf_area * bsdf.reverse_specular_pdf(v.frame.to_local(wi)) / dot(v.departure.ng, wo);
}

LightPathPlan plan_light_paths(const PathContext& context, const Vec2f& display_size, float mean_level) {
  // Relative variances per sample. A frame in which all casters have less is left to camera paths, and so is each caster
  // that has little.
  constexpr double kLeastOfAll = 0.05, kLeast = 0.01, kLeastOfLargest = 0.02;
  constexpr uint32_t kPilot = 16384, kPilotOfEach = 4096;
  const std::vector<uint32_t> found = find_casters(context.scene);
  if (found.empty() || !(mean_level > 0) || context.settings.max_depth < 2) return {};
  LightPathPlan plan;
  plan.paths = static_cast<uint32_t>(
      std::min(kMostLightPaths, std::ceil(kLightPathsPerPixel * display_size.x * display_size.y)));

  // Measure the noise of each caster.
  PathContext pilot = context;
  LightPathPlan alone;
  alone.paths = plan.paths;
  pilot.light_paths = &alone;
  std::vector<CasterNoise> noises;
  double all = 0, largest = 0;
  for (const uint32_t caster : found) {
    alone.casters = {{caster, 1}};
    alone.spread_chances(context.scene);
    const auto samples = std::min(kPilotOfEach, kPilot / static_cast<uint32_t>(found.size()));
    noises.push_back(noise_of(pilot, display_size, mean_level, samples));
    all += noises.back().camera;
    largest = std::max(largest, noises.back().camera);
  }
  if (!(all > kLeastOfAll)) return {};

  // The least sum of the variances of light paths has them in proportion to the roots.
  double total = 0;
  for (size_t i = 0; i < found.size(); ++i) {
    if (!(noises[i].camera > std::max(kLeast, kLeastOfLargest * largest)) || !(noises[i].light > 0)) continue;
    plan.casters.push_back({found[i], static_cast<float>(std::sqrt(noises[i].light))});
    total += plan.casters.back().chance;
  }
  for (LightPathPlan::Caster& caster : plan.casters) caster.chance = static_cast<float>(caster.chance / total);
  plan.spread_chances(context.scene);
  return plan;
}

namespace {

LightPathTracer tracer_of(SubsurfaceMode mode) {
  switch (mode) {
    case SubsurfaceMode::walk:
    case SubsurfaceMode::reference:
      return trace_light_path<SubsurfaceMode::walk>;
    case SubsurfaceMode::diffusion:
      return trace_light_path<SubsurfaceMode::diffusion>;
    case SubsurfaceMode::automatic:
      return trace_light_path<SubsurfaceMode::automatic>;
    case SubsurfaceMode::lambert:
      break;
  }
  return trace_light_path<SubsurfaceMode::lambert>;
}

}  // namespace

LightPathTracer select_light_path_tracer(const SceneFeatures& features, const IntegratorSettings& settings) {
  return tracer_of(features.subsurface ? settings.subsurface : SubsurfaceMode::lambert);
}

}  // namespace alabaster
