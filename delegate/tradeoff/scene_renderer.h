// Renders one scene repeatedly with different settings. The scene is loaded once, and meshes are refined again only
// where a configuration requires it.
#pragma once

#include <atomic>
#include <optional>

#include "delegate/host/frame_recorder.h"
#include "delegate/tradeoff/configurations.h"
#include "delegate/tradeoff/image.h"
#include "delegate/tradeoff/state.h"

namespace alabaster::tradeoff {

struct RenderedFrame {
  Image image;     // rendering space, premultiplied
  Image denoised;  // the same; empty unless asked for
  RenderCost cost;
};

/// Borrows the pointers in Scene, which must outlive it. One thread.
class SceneRenderer {
 public:
  struct Scene {
    hd::host::RetainedSceneDelegate* scene = nullptr;
    hd::host::RenderIndex* index = nullptr;  // that `scene` populates
    hd::Path settings;                       // of the RenderSettings prim
    const std::atomic<bool>* cancel = nullptr;
    hd::DiagnosticSink diagnostics;
  };
  explicit SceneRenderer(Scene scene);

  void set_size(int width, int height);
  /// None if the render was cancelled (`cancelled`), or if it failed and this was reported.
  std::optional<RenderedFrame> render(const Configuration& configuration, uint64_t samples, uint32_t seed,
                                      bool denoise = false);
  bool cancelled() const { return scene_.cancel && *scene_.cancel; }

 private:
  void refine(int coarser);

  Scene scene_;
  hd::RenderSettingsDescription frame_;  // without products and crop
  std::map<hd::Path, int> levels_;       // the scene's, of the subdivided meshes
  int coarser_ = 0;
};

}  // namespace alabaster::tradeoff
