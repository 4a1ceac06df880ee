#include "core/session/tile_renderer.h"

#include "core/sampling/pixel_sampler.h"

namespace alabaster {
namespace {

IntegratorSettings integrator_settings(const RenderSettings& s) {
  IntegratorSettings out;
  out.max_depth = s.max_depth;
  out.roulette_depth = s.roulette_depth;
  out.subsurface = s.subsurface;
  out.inversion = s.inversion;
  out.walk.weights = s.walk_weights;
  const bool shortcuts = s.subsurface != SubsurfaceMode::reference;
  out.walk.guiding = shortcuts && s.walk_guiding;
  out.walk.sphere_steps = shortcuts && s.walk_sphere_steps;
  return out;
}

}  // namespace

SampleFailure::SampleFailure(const CheckFailure& failure, const SampleAddress& where)
    : CheckFailure(std::string(failure.what()) + " in sample " + std::to_string(where.sample) + " of pixel " +
                   std::to_string(where.x) + "," + std::to_string(where.y)),
      at(where) {}

TileRenderer::TileRenderer(const RenderRequest& request)
    : request_(request),
      camera_(request.camera, request.width, request.height, request.scene->origin),
      integrator_settings_(integrator_settings(request.settings)),
      has_layers_((request.aovs & kLayerAovs) != 0),
      trace_path_(select_path_integrator(request.scene->features, integrator_settings_, has_layers_)) {}

FilmSample TileRenderer::trace_sample(const SampleAddress& at, RenderCounters* counters, LightLayers* layers,
                                      PathRecord* record) const {
  // Place the sample in the pixel's filter and on the lens.
  const RenderSettings& settings = request_.settings;
  const PixelSampler sampler(pixel_seed(at.x, at.y, settings.frame, settings.seed), at.sample);
  const auto u = sampler.draw(Dimension::film_lens, 0);
  const Vec2f offset = sample_pixel_filter(settings.filter, {u[0], u[1]});
  const Vec2f film_position(static_cast<float>(at.x) + 0.5f + offset.x, static_cast<float>(at.y) + 0.5f + offset.y);

  // Trace its path.
  const PathContext context{*request_.scene, camera_, integrator_settings_, *counters, layers, request_.aovs, record};
  const Ray ray = camera_.generate_ray(film_position, {u[2], u[3]});
  FilmSample result;
  try {
    result = trace_path_(context, ray, sampler);
  } catch (const CheckFailure& failure) {
    throw SampleFailure(failure, at);
  }
  ++counters->samples;

  // One bad number would spoil every later sum of its pixel.
  if (!is_finite(result.color)) {
    ++counters->nonfinite_samples;
    counters->note_nonfinite(at);
    result.color = Rgb(0.0f);
    *layers = {};
  }
  return result;
}

bool TileRenderer::render(const TileSamples& samples, const std::function<bool()>& may_go_on, FilmTile* tile,
                          RenderCounters* counters) const {
  const PixelRect& window = request_.data_window;
  const PixelRect& rect = samples.rect;
  LightLayers layers;
  size_t pixel = 0;  // in the tile
  for (int y = rect.y0; y < rect.y1; ++y)
    for (int x = rect.x0; x < rect.x1; ++x, ++pixel) {
      // Skip pixels whose group has ended.
      if (!(samples.groups >> pixel_group(x, y) & 1)) continue;

      // Take the pixel's share of the range, in sample order.
      const size_t in_window =
          static_cast<size_t>(y - window.y0) * static_cast<size_t>(window.width()) + static_cast<size_t>(x - window.x0);
      const uint64_t rays_before = counters->rays();
      const uint32_t end = samples.allocation.samples(in_window, samples.range.end);
      for (uint32_t s = samples.allocation.samples(in_window, samples.range.begin); s < end; ++s) {
        if (!may_go_on()) return false;
        tile->add(pixel, trace_sample({x, y, s}, counters, &layers), has_layers_ ? &layers : nullptr);
      }

      // Count what the pixel cost.
      if (samples.rays) (*samples.rays)[in_window] += static_cast<uint32_t>(counters->rays() - rays_before);
    }
  return true;
}

}  // namespace alabaster
