#include "delegate/rendering/framing.h"

#include <cmath>

namespace alabaster::hd::sync {
namespace {

// Hydra's conformed windows: the camera's window keeps its centre and takes the image's aspect ratio.
void conform_apertures(double aspect, WindowPolicy policy, CameraParameters* camera) {
  const double horizontal = static_cast<double>(camera->horizontal_aperture);
  const double vertical = static_cast<double>(camera->vertical_aperture);
  const bool wider = horizontal > vertical * aspect;  // the camera's window is wider than the image
  bool keep_vertical = true;
  switch (policy) {
    case WindowPolicy::dontConform:
      return;
    case WindowPolicy::matchVertically:
      break;
    case WindowPolicy::matchHorizontally:
      keep_vertical = false;
      break;
    case WindowPolicy::fit:  // all of the camera's window is seen
      keep_vertical = !wider;
      break;
    case WindowPolicy::crop:  // nothing but the camera's window is seen
      keep_vertical = wider;
      break;
  }
  if (keep_vertical)
    camera->horizontal_aperture = static_cast<float>(vertical * aspect);
  else
    camera->vertical_aperture = static_cast<float>(horizontal / aspect);
}

/// Widens lower..upper to whole pixels; returns the first and scales the aperture accordingly. `direction`: 1 where
/// pixels and film run the same way, -1 where they run against each other.
int widen(float lower, float upper, float direction, float* aperture, float* offset, int* size) {
  const float first = std::floor(lower), last = std::ceil(upper);
  const float scale = *aperture / (upper - lower);
  *offset += direction * scale * ((first + last) - (lower + upper)) * 0.5f;
  *aperture = (first == lower && last == upper) ? *aperture : scale * (last - first);
  *size = static_cast<int>(last - first);
  return static_cast<int>(first);
}

}  // namespace

FramedCamera frame_camera(const CameraParameters& camera, const Framing& framing, WindowPolicy policy) {
  FramedCamera out;
  out.camera = camera;
  const Vec2f size = framing.displayMax - framing.displayMin;
  conform_apertures(
      static_cast<double>(size.x) * static_cast<double>(framing.pixelAspectRatio) / static_cast<double>(size.y), policy,
      &out.camera);
  out.buffer_x = widen(framing.displayMin.x, framing.displayMax.x, 1, &out.camera.horizontal_aperture,
                       &out.camera.horizontal_aperture_offset, &out.width);
  out.buffer_y = widen(framing.displayMin.y, framing.displayMax.y, -1, &out.camera.vertical_aperture,
                       &out.camera.vertical_aperture_offset, &out.height);
  const Rect2i& d = framing.dataWindow;
  out.data_window = {d.minX - out.buffer_x, d.minY - out.buffer_y, d.maxX - out.buffer_x, d.maxY - out.buffer_y};
  return out;
}

}  // namespace alabaster::hd::sync
