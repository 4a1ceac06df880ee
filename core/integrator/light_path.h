// Light paths: light that a glossy surface reflects onto another, which the camera sees.
//
// From the camera such light is found by a direction at the first surface, x, that happens to lead to where the second,
// y, shines: rarely, and then with a great weight, a firefly. A light path begins at y, at a point drawn by area,
// samples a light there, reflects it by the specular lobe, and shows where it lands, x, to the camera (light tracing:
// Dutre, Lafortune, Willems 1993; Veach 1997, 10.2.2). Both ways estimate the same integral. With the point of the
// light sampled alike, their densities over the film and y differ by the ratio
//
//   r = n p_A(y) p_s(y -> x) cos_x / (J p(x -> y) cos_y)
//
// n: light paths a sample of the frame, p_A: density of y by area, p_s: density of the specular lobe for a viewer at
// the light, p: density of the camera's path, summed over the paths that split there, cos: cosines of facets to the
// segment x y, whose squared length cancels, J: pixels per area at x. The light path counts r^2 / (1 + r^2) (the power
// heuristic, Veach 1997, 9.2.3), the camera's the rest: of the part of f that is specular at y, whether a light was
// sampled there or its direction met one that sampling knows. Where r is small, light paths have no share.
//
// Which surfaces they begin at is planned for each frame (plan_light_paths()): those whose reflections would be noise.
#pragma once

#include <vector>

#include "core/integrator/path_state.h"

namespace alabaster {

/// Light paths of a sample of the frame, for each pixel of the display window, and how many at most: their landings
/// take memory.
inline constexpr float kLightPathsPerPixel = 1.0f / 32, kMostLightPaths = 1 << 16;

/// Where light paths begin, and how many there are.
struct LightPathPlan {
  struct Caster {
    uint32_t instance;
    float chance;  // that a light path begins there; all chances sum to one
  };
  uint32_t paths = 0;  // how many a sample of the frame has
  std::vector<Caster> casters;
  std::vector<float> triangle_chance;  // that a light path begins at one triangle, by instance; 0 beyond the end
  Vec2f film_begin{-1e9f, -1e9f}, film_end{1e9f, 1e9f};  // landings outside are not wanted

  bool empty() const { return casters.empty(); }
  bool wants(const Vec2f& film) const {
    return film.x >= film_begin.x && film.y >= film_begin.y && film.x < film_end.x && film.y < film_end.y;
  }
  /// Makes triangle_chance from the casters.
  void spread_chances(const SceneSnapshot& scene);
};

/// Light of a light path that has come to the film.
struct LightLanding {
  Vec2f film;
  Rgb color{0.0f};
  Rgb specular{0.0f};  // the part of color that x reflects by its specular lobes
  float share = 0;     // r^2 / (1 + r^2), a factor of color
  float ratio = 0;     // r
};

/// Traces one light path: appends a landing for each light that it samples and each surface that the camera sees it
/// land on. `context.light_paths` is not null.
using LightPathTracer = void (*)(const PathContext& context, const PixelSampler& sampler,
                                 std::vector<LightLanding>* landings);
LightPathTracer select_light_path_tracer(const SceneFeatures& features, const IntegratorSettings& settings);

/// The factors of r that are known at the first surface, `v`, where the ray of `from` ends and that of `to` begins.
float light_path_ratio_from(const PathContext& context, const PathVertex& v, const PathState& from,
                            const PathState& to);
/// All factors of r but p_s, where the ray of `path`, which has those, met `v`. 0 if light paths do not begin there.
float light_path_ratio_at(const PathContext& context, const PathState& path, const PathVertex& v);
/// r for light from unit direction `wi`. `known`: light_path_ratio_at(). `bsdf`: that of `v`.
float light_path_ratio(float known, const PathVertex& v, const DisneyBsdf& bsdf, const Vec3f& wi);

/// The share of light paths. Below a ratio of a twentieth it would be less than one part in 400.
inline float light_path_share(float ratio) {
  if (!(ratio > 0.05f)) return 0;
  const float squared = ratio * ratio;
  return squared < std::numeric_limits<float>::infinity() ? squared / (1 + squared) : 1;
}

/// The instances at which light paths may begin, in order. None if they are too many to be tried.
std::vector<uint32_t> find_casters(const SceneSnapshot& scene, const IntegratorSettings& settings);

/// Chooses the casters whose reflections would be noise, from a few light paths of each. `mean_level`: of the
/// picture, mean of red, green and blue. An empty plan: camera paths find all light. `context` stands for any sample;
/// its `light_paths` are not read. Throws BuildCancelled.
LightPathPlan plan_light_paths(const PathContext& context, const std::vector<uint32_t>& casters,
                               const Vec2f& display_size, float mean_level);

}  // namespace alabaster
