// The inputs of a render: scene, camera, windows, AOVs and settings.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/camera/camera.h"
#include "core/denoise/denoiser.h"
#include "core/film/film.h"
#include "core/scene/scene.h"
#include "core/session/render_settings.h"
#include "core/session/render_state.h"

namespace alabaster {

/// All inputs of a render. Requests that differ in settings of setting_use::kContinues alone, or lack AOVs, may share
/// samples (RenderSession::can_continue).
struct RenderRequest {
  std::shared_ptr<const SceneSnapshot> scene;
  CameraParameters camera;
  int width = 0, height = 0;  // display window: the camera is framed to it
  PixelRect data_window;      // pixels to render; may be a crop of, or larger than (overscan), the display window
  AovSet aovs = aov_bit(Aov::color);
  RenderSettings settings;
  std::vector<UvSetName> primvars = {};  // those that AOVs from primvar_aov(0) on show, kMostPrimvarAovs at most
  /// Names of the light groups that Aov::light_group shows, by their planes, kMostLightGroups at most. Light of no
  /// group has the empty name.
  std::vector<std::string> light_groups = {};
  std::shared_ptr<MemoryBudget> memory = {};  // of what grows with samples (Film::count_ids_in()); null: not counted
  MaterialNumbers materials = {};             // for kMaterialIdAovs; null: not asked for
  InstanceMattes mattes = {};                 // for kPrimCountAovs; null: each prim has one
  std::shared_ptr<const Denoiser> denoiser;   // makes AOV `denoised`, which is color without it
  /// A render of the same scene, view and settings, which this one continues and whose film it takes. Null: none.
  /// Without a scene its film is shown, and nothing is rendered.
  std::shared_ptr<RenderState> resumed = {};
};

}  // namespace alabaster
