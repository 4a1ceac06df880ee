// From camera, framing and window policy to what core renders.
#pragma once

#include "core/camera/camera.h"
#include "core/film/film.h"
#include "delegate/api/scene_types.h"

namespace alabaster::hd::sync {

struct FramedCamera {
  CameraParameters camera;  // apertures conformed to the display window
  int width = 0, height = 0;
  PixelRect data_window;           // relative to the display window's corner
  int buffer_x = 0, buffer_y = 0;  // where data_window's (0, 0) lies in the buffer, y-down
  bool operator==(const FramedCamera&) const = default;
};

/// `framing` must be valid. A display window with fractional edges is widened to whole pixels, and the apertures with
/// it, so that every pixel sees what it would have seen.
FramedCamera frame_camera(const CameraParameters& camera, const Framing& framing, WindowPolicy policy);

}  // namespace alabaster::hd::sync
