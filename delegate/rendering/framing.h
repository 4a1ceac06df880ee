// A camera, a framing and a window policy as core's camera and film windows.
#pragma once

#include <string>

#include "core/camera/camera.h"
#include "core/film/film.h"
#include "delegate/api/scene_types.h"

namespace alabaster::hd::rendering {

struct FramedCamera {
  CameraParameters camera;  // apertures conformed to the display window
  int width = 0, height = 0;
  PixelRect data_window;           // relative to the display window's corner
  int buffer_x = 0, buffer_y = 0;  // where data_window's (0, 0) lies in the buffer, y-down
  bool operator==(const FramedCamera&) const = default;
};

/// Why nothing can be rendered with `framing`: a number that is not finite, a pixel aspect ratio that is not positive,
/// a window that is inside out, or more than 2^20 pixels from the origin. Empty where it can; an empty window is no
/// fault.
std::string framing_fault(const Framing& framing);

/// `framing` must be valid and without fault. A display window with fractional edges is widened to whole pixels, and
/// the apertures with it, so that every pixel sees what it would have seen.
FramedCamera frame_camera(const CameraParameters& camera, const Framing& framing, WindowPolicy policy);

}  // namespace alabaster::hd::rendering
