// Traces the camera samples of a frame, tile by tile. A tile's pixels depend on the request, on their samples and, in
// adaptive frames, on the allocation alone: neither the thread nor the way in which the samples are split into ranges
// changes a bit.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/convergence/pixel_group.h"
#include "core/convergence/sample_allocation.h"
#include "core/diagnostics/counters.h"
#include "core/integrator/camera_interiors.h"
#include "core/integrator/path_integrator.h"
#include "core/session/pass_schedule.h"
#include "core/session/render_request.h"

namespace alabaster {

/// Which samples to add to a tile.
struct TileSamples {
  PixelRect rect;                      // of the tile
  SamplePass pass;                     // samples per pixel of an even frame
  const SampleAllocation& allocation;  // how many samples each pixel takes for that many
  uint32_t groups = kAllPixelGroups;   // pixels of other groups stay as they are
};

/// A failed check, and the sample that failed it.
struct SampleFailure : std::logic_error {
  SampleFailure(const std::string& failure, const SampleAddress& where);
  SampleAddress at;
};

/// Immutable: any number of threads may share one.
class TileRenderer {
 public:
  /// `request` must outlive the renderer. Images are filtered, and walks go on, until `cancel`: then BuildCancelled is
  /// thrown. A sample that is cancelled is not added to its pixel.
  explicit TileRenderer(const RenderRequest& request, const CancelToken& cancel = {});

  /// Traces one camera sample of an even frame. The result depends on its address and the request alone. A colour that
  /// is not finite is counted and becomes black. `layers`, never null, are filled if the request has any of kLayerAovs;
  /// the path is written to `record`, unless that is null. A check that fails throws a SampleFailure.
  FilmSample trace_sample(const SampleAddress& at, RenderCounters* counters, LightLayers* layers,
                          PathRecord* record = nullptr) const;

  /// Adds to `tile`, a FilmTile or what looks like one, the samples that its pixels lack up to the end of the pass.
  /// `may_go_on()` is asked before each sample. False: it returned false, or a sample was cancelled, and some pixels
  /// lack their samples. The rays of that sample are counted.
  template <class MayGoOn, class Tile>
  bool render(const TileSamples& samples, const MayGoOn& may_go_on, Tile* tile, RenderCounters* counters) const;

 private:
  uint32_t seed_of(int x, int y) const { return pixel_seed(x, y, request_.settings.frame, request_.settings.seed); }
  // Where a sample puts what is not in its FilmSample.
  struct SampleParts {
    LightLayers* layers;
    HitVectors* vectors;         // null: no AOV shows them
    PathRecord* record;          // null: none
    LightByGroup* light_groups;  // null: no AOV shows them
  };
  FilmSample trace_sample(const SampleAddress& at, const PixelSampler& sampler, RenderCounters* counters,
                          const SampleParts& parts) const;

  NonfiniteCause nonfinite_cause(const PathContext& path, const Ray& ray, const PixelSampler& sampler) const;

  const RenderRequest& request_;
  MovingCamera camera_;
  std::optional<MovingCamera> ends_;  // CameraParameters::ends; none: there are none
  bool has_motion_;                   // of the scene or the camera: rays have a time
  float exposure_;                    // factor of radiance
  IntegratorSettings integrator_settings_;
  bool has_layers_, has_vectors_;
  std::optional<const LightByGroup> light_groups_;  // empty; none: no AOV shows any
  bool begins_behind_fronts_ = false;
  std::unique_ptr<const CameraInteriors> camera_interiors_;  // null: camera rays begin outside of clear bodies
};

template <class MayGoOn, class Tile>
bool TileRenderer::render(const TileSamples& samples, const MayGoOn& may_go_on, Tile* tile,
                          RenderCounters* counters) const {
  const PixelRect& window = request_.data_window;
  const PixelRect& rect = samples.rect;
  const int step = samples.pass.block;
  LightLayers layers;
  HitVectors vectors;
  std::optional<LightByGroup> groups;
  if (light_groups_) groups.emplace(*light_groups_);
  const SampleParts parts{&layers, has_vectors_ ? &vectors : nullptr, nullptr, groups ? &*groups : nullptr};
  for (int y = rect.y0; y < rect.y1; y += step)
    for (int x = rect.x0; x < rect.x1; x += step) {
      // Skip pixels whose group has ended.
      if (!is_in(samples.groups, x, y)) continue;

      // Take the samples that the pixel lacks, in their order.
      const auto pixel =
          static_cast<size_t>(y - rect.y0) * static_cast<size_t>(rect.width()) + static_cast<size_t>(x - rect.x0);
      const size_t in_window =
          static_cast<size_t>(y - window.y0) * static_cast<size_t>(window.width()) + static_cast<size_t>(x - window.x0);
      const uint32_t seed = seed_of(x, y), end = samples.allocation.samples(in_window, samples.pass.end);
      for (uint32_t s = tile->next_sample(pixel); s < end; ++s) {
        if (!may_go_on()) return false;
        const uint64_t rays_before = counters->rays();
        try {
          const FilmSample sample = trace_sample({x, y, s}, {seed, s}, counters, parts);
          tile->add(pixel, sample, has_layers_ ? &layers : nullptr,
                    static_cast<uint32_t>(counters->rays() - rays_before));
        } catch (const BuildCancelled&) {
          return false;
        }
      }
    }
  return true;
}

}  // namespace alabaster
