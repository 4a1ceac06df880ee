#include "delegate/rendering/framing.h"

#include <cmath>

#include "delegate/support/window_policy.h"

namespace alabaster::hd::rendering {
namespace {

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

std::string window_text(const Vec2f& low, const Vec2f& high) {
  return Value(low).to_string() + " to " + Value(high).to_string();
}

}  // namespace

std::string framing_fault(const Framing& framing) {
  constexpr float kLimit = 1 << 20;  // beyond it, pixel coordinates are no longer exact in float
  const Vec2f& low = framing.displayMin;
  const Vec2f& high = framing.displayMax;
  const Rect2i& d = framing.dataWindow;
  const Vec2f data_low(static_cast<float>(d.minX), static_cast<float>(d.minY));
  const Vec2f data_high(static_cast<float>(d.maxX), static_cast<float>(d.maxY));
  const std::string display = "the framing's display window, " + window_text(low, high) + ", ";
  for (const float edge : {low.x, low.y, high.x, high.y})
    if (!std::isfinite(edge)) return display + "is not finite";
  if (!(framing.pixelAspectRatio > 0) || !std::isfinite(framing.pixelAspectRatio))
    return "the framing's pixel aspect ratio is " + Value(framing.pixelAspectRatio).to_string() +
           "; it must be positive and finite";
  if (high.x < low.x || high.y < low.y) return display + "is inside out";
  if (d.maxX < d.minX || d.maxY < d.minY)
    return "the framing's data window, " + window_text(data_low, data_high) + ", is inside out";
  for (const Vec2f& corner : {low, high, data_low, data_high})
    if (std::abs(corner.x) > kLimit || std::abs(corner.y) > kLimit) return "the framing exceeds 2^20 pixels";
  return {};
}

FramedCamera frame_camera(const CameraParameters& camera, const Framing& framing, WindowPolicy policy) {
  FramedCamera out;
  out.camera = camera;
  const Vec2f size = framing.displayMax - framing.displayMin;
  const support::CameraWindow film = support::conform_window(
      {static_cast<double>(camera.horizontal_aperture), static_cast<double>(camera.vertical_aperture)},
      static_cast<double>(size.x) * static_cast<double>(framing.pixelAspectRatio) / static_cast<double>(size.y),
      policy);
  out.camera.horizontal_aperture = static_cast<float>(film.width);
  out.camera.vertical_aperture = static_cast<float>(film.height);
  out.buffer_x = widen(framing.displayMin.x, framing.displayMax.x, 1, &out.camera.horizontal_aperture,
                       &out.camera.horizontal_aperture_offset, &out.width);
  out.buffer_y = widen(framing.displayMin.y, framing.displayMax.y, -1, &out.camera.vertical_aperture,
                       &out.camera.vertical_aperture_offset, &out.height);
  const Rect2i& d = framing.dataWindow;
  out.data_window = {d.minX - out.buffer_x, d.minY - out.buffer_y, d.maxX - out.buffer_x, d.maxY - out.buffer_y};
  return out;
}

}  // namespace alabaster::hd::rendering
