#include "core/session/tile_renderer.h"

#include "core/diagnostics/check.h"

namespace alabaster {

SampleFailure::SampleFailure(const std::string& failure, const SampleAddress& where)
    : std::logic_error(failure + " in sample " + std::to_string(where.sample) + " of pixel " + std::to_string(where.x) +
                       "," + std::to_string(where.y)),
      at(where) {}

TileRenderer::TileRenderer(const RenderRequest& request)
    : request_(request),
      camera_(request.camera, request.width, request.height, request.scene->origin),
      integrator_settings_(integrator_settings(request.settings)),
      has_layers_((request.aovs & kLayerAovs) != 0),
      trace_path_(select_path_integrator(request.scene->features, integrator_settings_, has_layers_)) {}

FilmSample TileRenderer::trace_sample(const SampleAddress& at, RenderCounters* counters, LightLayers* layers,
                                      PathRecord* record) const {
  return trace_sample(at, {seed_of(at.x, at.y), at.sample}, counters, layers, record);
}

FilmSample TileRenderer::trace_sample(const SampleAddress& at, const PixelSampler& sampler, RenderCounters* counters,
                                      LightLayers* layers, PathRecord* record) const {
  // Place the sample in the pixel's filter and on the lens.
  const auto u = sampler.draw(Dimension::film_lens, 0);
  const Vec2f offset = sample_pixel_filter(request_.settings.filter, {u[0], u[1]});
  const Vec2f film_position(static_cast<float>(at.x) + 0.5f + offset.x, static_cast<float>(at.y) + 0.5f + offset.y);

  // Trace its path.
  const PathContext context{*request_.scene, camera_, integrator_settings_, *counters, layers, request_.aovs, record};
  const Ray ray = camera_.generate_ray(film_position, {u[2], u[3]});
  FilmSample result;
  try {
    result = trace_path_(context, ray, sampler);
  } catch (const CheckFailure& failure) {
    throw SampleFailure(failure.what(), at);
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

}  // namespace alabaster
