#include "core/integrator/light_path.h"

#include <algorithm>
#include <cmath>

#include "core/integrator/camera_interiors.h"
#include "core/integrator/direct_light.h"
#include "core/integrator/path_surface.h"
#include "core/integrator/surface_light.h"

namespace alabaster {

namespace {

// Normals bend towards those who see them at a grazing angle (bend_towards). Light paths keep to directions in which
// none does, so that both ways have the same frame.
constexpr float kLeastCosine = 0.011f;

// Denser directions at the first surface are those of a narrow lobe. They find the second surface well, and a light
// path would meet the lobe by chance.
constexpr float kMostPdf = 1;

// The density, by area in render space, with which light paths begin at the triangle; 0: none does.
float begin_pdf(const SceneSnapshot& scene, const LightPathPlan& plan, uint32_t caster, uint32_t triangle) {
  if (caster >= plan.triangle_chance.size() || !(plan.triangle_chance[caster] > 0)) return 0;
  const Instance& instance = scene.instances[caster];
  const auto corners = instance.prototype->mesh.corners_at(triangle, 0);
  const Affine& map = instance.object_to_world;
  const Vec3d a(map.vector(corners[1] - corners[0])), b(map.vector(corners[2] - corners[0]));
  const auto pdf = static_cast<float>(plan.triangle_chance[caster] / (0.5 * a.cross(b).length()));
  return std::isfinite(pdf) ? pdf : 0;
}

// The point where a light path begins, on the outer side of its surface.
struct PathBegin {
  TriangleHit triangle;
  PathVertex v;
  float pdf_area;
};

std::optional<PathBegin> choose_begin(const PathContext& context, const PixelSampler& sampler) {
  // Choose a caster, and a triangle of it; all its triangles have the same chance. A number of 24 bits could not reach
  // each of many.
  const LightPathPlan& plan = *context.light_paths;
  const auto u = sampler.draw(Dimension::light_path, 0);
  double rest = double(u[0]) + double(u[3]) * 0x1p-24;
  size_t i = 0;
  while (i + 1 < plan.casters.size() && rest >= double(plan.casters[i].chance))
    rest -= double(plan.casters[i++].chance);
  const auto [caster, chance] = plan.casters[i];
  const Instance& instance = context.scene.instances[caster];
  const Mesh& mesh = instance.prototype->mesh;
  const size_t count = mesh.triangles.size();

  // Choose a point of the triangle.
  PathBegin begin;
  begin.triangle.instance = caster;
  const auto chosen = static_cast<size_t>(std::clamp(rest / double(chance), 0.0, 1.0) * static_cast<double>(count));
  begin.triangle.triangle = static_cast<uint32_t>(std::min(chosen, count - 1));
  const Vec2f b = sample_uniform_triangle({u[1], u[2]});
  begin.triangle.u = b.x, begin.triangle.v = b.y;
  const auto corners = mesh.corners_at(begin.triangle.triangle, 0);
  begin.triangle.normal = cross(corners[1] - corners[0], corners[2] - corners[0]);
  begin.pdf_area = begin_pdf(context.scene, plan, caster, begin.triangle.triangle);
  if (!(begin.pdf_area > 0)) return std::nullopt;

  // Look at it from above.
  const SurfacePoint point = surface_point(mesh, begin.triangle, instance.object_to_world, instance.world_to_object);
  begin.v = make_vertex(context, {point.p + point.ng, -point.ng}, begin.triangle);
  return begin.v.mapped ? std::nullopt : std::optional(begin);
}

// True if the triangles have one or two corners in common.
bool are_neighbours(const Mesh& mesh, uint32_t a, uint32_t b) {
  const Corners &of_a = mesh.triangles[a], &of_b = mesh.triangles[b];
  const auto common = std::count_if(
      of_a.begin(), of_a.end(), [&](auto corner) { return std::find(of_b.begin(), of_b.end(), corner) != of_b.end(); });
  return common == 1 || common == 2;
}

// True if the path's ray ends at `what`, at about this distance. Rounding may lead it to the triangle beside, but not
// to another surface that lies close by.
bool ends_at(const PathContext& context, const PixelSampler& sampler, const TriangleHit& what, float distance,
             PathState* path, TriangleHit* hit) {
  if (!trace(context, sampler, path, hit) || hit->instance != what.instance) return false;
  if (hit->triangle != what.triangle) {
    const Mesh& mesh = context.scene.instance(hit->instance).prototype->mesh;
    if (!(std::abs(hit->t - distance) < 1e-4f * distance) || !are_neighbours(mesh, hit->triangle, what.triangle))
      return false;
  }
  path->ray.tmax = hit->t;
  return true;
}

// Calls visit(hit) for each surface on which light along the ray may land: the first, and those behind where the
// camera's path, which comes the other way, may pass.
template <class Visit>
void for_each_landing(const PathContext& context, Ray ray, const Visit& visit) {
  const SceneSnapshot& scene = context.scene;
  constexpr int kMost = 256;  // as of interiors: rounding may hold a ray up
  for (int i = 0; i < kMost; ++i) {
    TriangleHit hit;
    ++context.counters.bounce_rays;
    if (!scene.top->intersect(ray, &hit)) return;
    const Instance& instance = scene.instance(hit.instance);
    std::optional<Placement> moved;
    const Placement& placement = instance.at(hit, &moved);
    const SurfacePoint point = on_side(
        surface_point(instance.prototype->mesh, hit, placement.object_to_world, placement.world_to_object), -ray.dir);
    visit(hit, point);
    if (!instance.see_through || !(coverage_at(scene, -ray.dir, hit, nullptr) < 1)) return;
    ray.org = offset_point(point.p, -point.ng, point.offset);
  }
}

// A light path between its light and where it lands.
struct Reflection {
  const PathBegin& begin;
  LightSample light;
  float arrives;       // the share of the light
  Vec3f onward;        // unit
  float pdf_specular;  // of onward
};

// Follows the path that the camera would take to where the light landed, and from there to where the light path began:
// everything but the densities of the light path itself is what that path would find.
template <SubsurfaceMode kMode>
std::optional<LightLanding> show_landing(const PathContext& context, const PixelSampler& sampler, const Reflection& way,
                                         const TriangleHit& landed, const SurfacePoint& at) {
  // Find where the camera sees the point.
  const auto u = sampler.draw(Dimension::film_lens, 0);
  const auto film = context.camera.film_position(at.p, {u[0], u[1]});
  if (!film || !context.light_paths->wants(*film)) return std::nullopt;
  PathState path;
  path.ray = context.camera.generate_ray(*film, {u[0], u[1]});
  if (dot(at.ng, path.ray.dir) >= 0) return std::nullopt;
  if (context.camera_interiors && !context.camera_interiors->of(context, path.ray).empty()) return std::nullopt;
  if (keeps_footprints(context)) path.footprint.cone = context.camera.pixel_cone(path.ray.dir);
  TriangleHit hit;
  ++context.counters.bounce_rays;
  if (!ends_at(context, sampler, landed, dot(at.p - path.ray.org, path.ray.dir), &path, &hit)) return std::nullopt;
  const PathVertex x = find_vertex<kMode>(context, hit, &path);
  if (x.material.transmits() || continues_within_medium<kMode>(context, x, path)) return std::nullopt;

  // Go on from there to where the light path began.
  const DisneyBsdf bsdf_x(x.material, x.frame.to_local(-path.ray.dir), context.settings.energy);
  const Vec3f to_y = way.begin.v.hit.p - x.departure.flat, dir = normalize(to_y), wi = x.frame.to_local(dir);
  if (!x.departure.is_above(dir) || !x.is_above_surface(dir)) return std::nullopt;
  Rgb specular;
  const BsdfValue value = bsdf_x.evaluate(wi, &specular);
  if (is_black(value.f) || !(value.pdf > 0) || x.instance->options.holdout) return std::nullopt;
  PathState second;
  second.depth = 1;
  second.footprint = path.footprint;
  second.hollows = path.hollows;
  if (keeps_footprints(context)) second.footprint.scatter(value.pdf);
  second.go_on(x.departure.flat, dir);
  second.scatter_pdf = value.pdf * static_cast<float>(kPathsPerSample);
  second.light_path_ratio = light_path_ratio_from(context, x, path, second);
  ++context.counters.bounce_rays;
  if (!ends_at(context, sampler, way.begin.triangle, length(to_y), &second, &hit)) return std::nullopt;
  const PathVertex y = find_vertex<kMode>(context, hit, &second);
  if (y.material.transmits() || continues_within_medium<kMode>(context, y, second)) return std::nullopt;
  if (way.light.of_constant_dome && (kMode == SubsurfaceMode::lambert || !y.material.scatters())) return std::nullopt;

  // Reflect the light there.
  const DisneyBsdf bsdf_y(y.material, y.frame.to_local(-dir), context.settings.energy);
  const Vec3f to_light = y.frame.to_local(way.light.wi);
  Rgb shine;
  bsdf_y.evaluate(to_light, &shine);
  LightLanding landing{*film};
  const float known = is_black(shine) ? 0 : light_path_ratio_at(context, second, y);
  landing.ratio = light_path_ratio(known, y, bsdf_y, way.light.wi);
  landing.share = light_path_share(landing.ratio);
  if (!(landing.share > 0)) return std::nullopt;

  // Weigh it: the light that both segments carry over the density of the light path, both over film and y.
  const float pixels = context.camera.pixels_per_area(path.ray.dir, x.hit.p) * -dot(x.departure.ng, path.ray.dir);
  const float pdf = way.begin.pdf_area * way.pdf_specular * way.light.pdf * dot(x.departure.ng, dir) *
                    static_cast<float>(context.light_paths->paths);
  const float carried = std::abs(wi.z) * to_light.z * -dot(y.departure.ng, dir) * way.arrives;
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
  const LightSearch search{
      kMode == SubsurfaceMode::lambert ? ConstantDomes::bsdf_sampling_only : ConstantDomes::sampled, ng};
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

// Relative variances of the light that a caster reflects, of a sample of a pixel.
struct CasterNoise {
  double camera = 0;  // without light paths
  double light = 0;   // of light paths, if all begin at this caster
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
      const double shared = luminance(l.color), whole = shared / l.share;
      noise.camera += whole * whole * l.ratio;
      noise.light += shared * shared;
    }
  }
  const double scale = context.light_paths->paths / (double(samples) * size.x * size.y * mean_level * mean_level);
  return {noise.camera * scale, noise.light * scale};
}

}  // namespace

void LightPathPlan::spread_chances(const SceneSnapshot& scene) {
  triangle_chance.assign(scene.instances.size(), 0);
  for (const Caster& caster : casters)
    triangle_chance[caster.instance] =
        caster.chance / static_cast<float>(scene.instances[caster.instance].prototype->mesh.triangles.size());
}

float light_path_ratio_from(const PathContext& context, const PathVertex& v, const PathState& from,
                            const PathState& to) {
  const Vec3f& wi = to.ray.dir;
  if (!v.departure.is_above(wi) || to.scatter_pdf > kMostPdf) return 0;
  const float pixels = context.camera.pixels_per_area(from.ray.dir, v.hit.p) * -dot(v.departure.ng, from.ray.dir);
  return static_cast<float>(context.light_paths->paths) * dot(v.departure.ng, wi) / (pixels * to.scatter_pdf);
}

float light_path_ratio_at(const PathContext& context, const PathState& path, const PathVertex& v) {
  const Vec3f wo = -path.ray.dir;
  if (v.mapped || !(dot(v.hit.ns, wo) > kLeastCosine)) return 0;
  const float pdf_area = begin_pdf(context.scene, *context.light_paths, v.triangle.instance, v.triangle.triangle);
  if (!(pdf_area > 0) || is_behind(*v.instance, v.triangle, path.ray.dir)) return 0;
  return path.light_path_ratio * pdf_area / dot(v.departure.ng, wo);
}

float light_path_ratio(float known, const PathVertex& v, const DisneyBsdf& bsdf, const Vec3f& wi) {
  if (!(known > 0) || !v.departure.is_above(wi) || !(dot(v.hit.ns, wi) > kLeastCosine)) return 0;
  return known * bsdf.reverse_specular_pdf(v.frame.to_local(wi));
}

std::vector<uint32_t> find_casters(const SceneSnapshot& scene, const IntegratorSettings& settings) {
  constexpr size_t kMost = 256;  // no pilot of more is cheap
  std::vector<uint32_t> casters;
  if (settings.max_depth < 2 || scene.lights.size() == 0) return casters;
  for (uint32_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    const bool shines = std::any_of(instance.materials.begin(), instance.materials.end(), [](const DisneyMaterial* m) {
      return !m->normal_map && (m->constants.specular > 0 || m->constants.metallic > 0);
    });
    if (shines && instance.stands_alone() && !instance.prototype->mesh.triangles.empty()) casters.push_back(i);
    if (casters.size() > kMost) return {};
  }
  return casters;
}

LightPathPlan plan_light_paths(const PathContext& context, const std::vector<uint32_t>& casters,
                               const Vec2f& display_size, float mean_level) {
  // Relative variances per sample. A frame in which all casters have less is left to camera paths, and so is each
  // caster that has little.
  constexpr double kLeastOfAll = 0.05, kLeast = 0.01, kLeastOfLargest = 0.02;
  constexpr uint32_t kPilot = 8192, kPilotOfEach = 2048;
  if (casters.empty() || !(mean_level > 0)) return {};
  LightPathPlan plan;
  plan.paths = static_cast<uint32_t>(
      std::min(kMostLightPaths, std::ceil(kLightPathsPerPixel * display_size.x * display_size.y)));

  // Measure the noise of each caster.
  PathContext pilot = context;
  LightPathPlan alone;
  alone.paths = plan.paths;
  alone.film_begin = {0, 0}, alone.film_end = display_size;
  pilot.light_paths = &alone;
  std::vector<CasterNoise> noises;
  double all = 0, largest = 0;
  for (const uint32_t caster : casters) {
    alone.casters = {{caster, 1}};
    alone.spread_chances(context.scene);
    const auto samples = std::min(kPilotOfEach, kPilot / static_cast<uint32_t>(casters.size()));
    noises.push_back(noise_of(pilot, display_size, mean_level, samples));
    all += noises.back().camera;
    largest = std::max(largest, noises.back().camera);
  }
  if (!(all > kLeastOfAll)) return {};

  // The least sum of the variances of light paths has them in proportion to the roots.
  const double least = std::max(kLeast, kLeastOfLargest * largest);
  double total = 0;
  for (const CasterNoise& noise : noises)
    if (noise.camera > least) total += std::sqrt(noise.light);
  if (!(total > 0) || !std::isfinite(total)) return {};
  for (size_t i = 0; i < casters.size(); ++i) {
    const auto chance = static_cast<float>(std::sqrt(noises[i].light) / total);
    if (noises[i].camera > least && chance > 0) plan.casters.push_back({casters[i], chance});
  }
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
