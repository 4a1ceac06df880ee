#include "core/session/tile_renderer.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "core/diagnostics/check.h"
#include "core/integrator/path_record.h"

namespace alabaster {

SampleFailure::SampleFailure(const std::string& failure, const SampleAddress& where)
    : std::logic_error(failure + " in sample " + std::to_string(where.sample) + " of pixel " + std::to_string(where.x) +
                       "," + std::to_string(where.y)),
      at(where) {}

namespace {

// A scene without images does not need to know what its paths cover.
IntegratorSettings settings_for(const RenderRequest& request, const CancelToken& cancel) {
  IntegratorSettings settings = integrator_settings(request.settings);
  settings.walk.cancel = cancel;
  if (!request.scene->features.textures) settings.texture_filter = 0;
  return settings;
}

void prepare_filtering(const SceneSnapshot& scene, const CancelToken& cancel) {
  std::vector<const Texture*> images;
  for (const auto& material : scene.materials)
    for (const MaterialTexture& texture : material->textures)
      if (texture.lookup.image && texture.lookup.is_linear) images.push_back(texture.lookup.image.get());
  tbb::parallel_for(size_t(0), images.size(), [&](size_t i) {
    if (images[i]->prepare_filtering(cancel)) return;
    throw std::runtime_error(std::string("the means of images cannot be written to a temporary file: ") +
                             std::strerror(errno) + "; raise textureMemory, or set textureFilter to 0");
  });
}

// By the scene's number of a light group.
std::vector<uint8_t> planes_of_groups(const RenderRequest& request) {
  CHECK_LE(request.light_groups.size(), kMostLightGroups);
  std::vector<std::string> groups = request.scene->light_groups;
  groups.insert(groups.begin(), "");
  std::vector<uint8_t> planes;
  for (const std::string& group : groups) {
    const auto shown = std::find(request.light_groups.begin(), request.light_groups.end(), group);
    const bool is_shown = shown != request.light_groups.end();
    planes.push_back(static_cast<uint8_t>(is_shown ? shown - request.light_groups.begin() : kMostLightGroups));
  }
  return planes;
}

// The origins of all rays that a render's camera may send.
Bounds ray_origins(const RenderRequest& request, const MovingCamera& camera) {
  constexpr float filter = 1.5f;  // radius of the widest filter, in pixels
  const PixelRect& window = request.data_window;
  const auto at = [](int x, int y) { return Vec2f(static_cast<float>(x), static_cast<float>(y)); };
  const Vec2f begin = at(std::min(0, window.x0), std::min(0, window.y0)) - Vec2f(filter);
  const Vec2f end = at(std::max(request.width, window.x1), std::max(request.height, window.y1)) + Vec2f(filter);
  return camera.ray_origins(begin, end);
}

std::optional<MovingCamera> camera_at_ends(const RenderRequest& request) {
  if (request.camera.ends.empty()) return std::nullopt;
  CameraParameters camera = request.camera;
  camera.poses = request.camera.ends;
  return MovingCamera(camera, request.width, request.height, request.scene->origin);
}

}  // namespace

TileRenderer::TileRenderer(const RenderRequest& request, const CancelToken& cancel)
    : request_(request),
      camera_(request.camera, request.width, request.height, request.scene->origin),
      ends_(camera_at_ends(request)),
      has_motion_(camera_.moves() || request.scene->features.motion),
      exposure_(std::exp2(request.camera.exposure)),
      integrator_settings_(settings_for(request, cancel)),
      has_layers_((request.aovs & kLayerAovs) != 0),
      has_vectors_((request.aovs & kVectorAovs) != 0) {
  if (!request.light_groups.empty()) light_groups_.emplace(planes_of_groups(request));
  if (integrator_settings_.texture_filter > 0) prepare_filtering(*request.scene, cancel);
  RenderCounters counters;  // the search is no part of a sample
  const Bounds origins = ray_origins(request, camera_);
  begins_behind_fronts_ = begin_behind_fronts(*request.scene, origins);
  camera_interiors_ = CameraInteriors::find({*request.scene, camera_.first(), integrator_settings_, counters}, origins);
}

FilmSample TileRenderer::trace_sample(const SampleAddress& at, RenderCounters* counters, LightLayers* layers,
                                      PathRecord* record) const {
  return trace_sample(at, {seed_of(at.x, at.y), at.sample}, counters, SampleParts{layers, nullptr, record, nullptr});
}

FilmSample TileRenderer::trace_sample(const SampleAddress& at, const PixelSampler& sampler, RenderCounters* counters,
                                      const SampleParts& parts) const {
  // Find when it is taken, place it in the pixel's filter and on the lens, and trace its path.
  std::optional<Camera> moved;
  float time = 0;
  if (has_motion_) [[unlikely]] {
    const float share = sampler.draw(Dimension::time, 0)[0];
    moved = camera_.at(share);
    time = camera_.time(share);
  }
  const Camera& camera = moved ? *moved : camera_.first();
  const auto u = sampler.draw(Dimension::film_lens, 0);
  const Vec2f offset = sample_pixel_filter(request_.settings.filter, {u[0], u[1]});
  const Vec2f film_position(static_cast<float>(at.x) + 0.5f + offset.x, static_cast<float>(at.y) + 0.5f + offset.y);
  PathContext context{
      *request_.scene, camera, integrator_settings_, *counters, has_layers_ ? parts.layers : nullptr, request_.aovs,
      parts.record,    time};
  context.camera_interiors = camera_interiors_.get();
  context.begins_behind_fronts = begins_behind_fronts_;
  context.light_groups = parts.light_groups;
  context.materials = request_.aovs & kMaterialIdAovs ? request_.materials.get() : nullptr;
  context.mattes = request_.aovs & kPrimCountAovs ? request_.mattes.get() : nullptr;
  std::optional<HitVectorRequest> vectors;
  std::optional<Camera> closes;
  if (parts.vectors) [[unlikely]] {
    const MovingCamera& through = ends_ ? *ends_ : camera_;
    closes = through.at(1);
    context.vectors = &vectors.emplace(HitVectorRequest{request_.primvars, through.first(), *closes, ends_.has_value(),
                                                        camera_.time(0), camera_.time(1), parts.vectors});
  }
  Ray ray = camera.generate_ray(film_position, {u[2], u[3]});
  ray.time = time;
  FilmSample result;
  try {
    result = trace_path(context, ray, sampler);
  } catch (const CheckFailure& failure) {
    throw SampleFailure(failure.what(), at);
  }
  ++counters->samples;
  if (exposure_ != 1) {
    result.color *= exposure_;
    result.shadowed *= exposure_, result.unshadowed *= exposure_;
    parts.layers->scale(exposure_);
    if (parts.light_groups) parts.light_groups->scale(exposure_);
  }

  // One bad number would spoil every later sum of its pixel.
  if (!is_finite(result.color)) {
    counters->note_nonfinite(at, nonfinite_cause(context, ray, sampler));
    result.color = Rgb(0.0f);
    result.nonfinite = true;
    *parts.layers = {};
    if (parts.light_groups) parts.light_groups->clear();
  }
  if (parts.light_groups) result.light_groups = parts.light_groups->planes();
  return result;
}

// Traces the path again, with a record that only looks for the cause.
NonfiniteCause TileRenderer::nonfinite_cause(const PathContext& path, const Ray& ray,
                                             const PixelSampler& sampler) const {
  PathRecord record;
  RenderCounters counters;
  IntegratorSettings settings = integrator_settings_;
  settings.walk.cancel = {};  // the sample has been counted
  PathContext context{*request_.scene, path.camera, settings, counters, nullptr, request_.aovs, &record, path.time};
  context.camera_interiors = path.camera_interiors;
  context.begins_behind_fronts = path.begins_behind_fronts;
  const FilmSample unexposed = trace_path(context, ray, sampler);
  return is_finite(unexposed.color) ? NonfiniteCause::exposure : record.cause();
}

}  // namespace alabaster
