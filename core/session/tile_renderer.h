// Traces the camera samples of a frame, tile by tile. A tile's pixels depend on the request and on their samples alone:
// neither the thread nor the way in which the samples are split into ranges changes a bit.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "core/camera/camera.h"
#include "core/convergence/pixel_group.h"
#include "core/convergence/sample_allocation.h"
#include "core/diagnostics/check.h"
#include "core/diagnostics/counters.h"
#include "core/film/film.h"
#include "core/integrator/path_integrator.h"
#include "core/scene/scene.h"
#include "core/session/pass_schedule.h"
#include "core/session/render_settings.h"

namespace alabaster {

struct RenderRequest {
  std::shared_ptr<const SceneSnapshot> scene;
  CameraParameters camera;
  int width = 0, height = 0;  // display window: the camera is framed to it
  PixelRect data_window;      // pixels to render; may be a crop of, or larger than (overscan), the display window
  uint32_t aovs = aov_bit(Aov::color);
  RenderSettings settings;
};

/// Which samples to add to a tile.
struct TileSamples {
  PixelRect rect;                      // of the tile
  SampleRange range;                   // of the samples per pixel of an even frame
  const SampleAllocation& allocation;  // how many samples each pixel takes for that range
  uint32_t groups = kAllPixelGroups;   // pixels of other groups stay as they are
  /// Row-major in the data window: the rays of each pixel are added. Null: they are not counted.
  std::vector<uint32_t>* rays = nullptr;
};

/// A failed check, and the sample that failed it.
struct SampleFailure : CheckFailure {
  SampleFailure(const CheckFailure& failure, const SampleAddress& where);
  SampleAddress at;
};

/// Immutable: any number of threads may share one.
class TileRenderer {
 public:
  /// `request` must outlive the renderer.
  explicit TileRenderer(const RenderRequest& request);

  /// Traces one camera sample. The result depends on its address and the request alone. A color that is not finite is
  /// counted and becomes black. `layers`, never null, are filled if the request has any of kLayerAovs; then the path is
  /// written to `record`, too, unless that is null. A check that fails throws a SampleFailure.
  FilmSample trace_sample(const SampleAddress& at, RenderCounters* counters, LightLayers* layers,
                          PathRecord* record = nullptr) const;

  /// Adds the samples to `tile`, which must hold all earlier ones. `may_go_on` is called before each sample. False: it
  /// returned false, and some pixels lack their samples.
  bool render(const TileSamples& samples, const std::function<bool()>& may_go_on, FilmTile* tile,
              RenderCounters* counters) const;

 private:
  const RenderRequest& request_;
  Camera camera_;
  IntegratorSettings integrator_settings_;
  bool has_layers_;
  PathIntegrator trace_path_;
};

}  // namespace alabaster
