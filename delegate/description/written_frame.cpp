#include <cmath>

#include "core/math/transform.h"
#include "delegate/description/apply_motion.h"
#include "delegate/description/schema_check.h"
#include "delegate/description/written_parts.h"
#include "delegate/support/window_policy.h"

namespace alabaster::hd::description {
namespace {

using nlohmann::json;

// The number that the reader multiplies to just this length in metres, if there is one.
float millimetres_of(float length) {
  constexpr float kMetresPerMillimetre = 0.001f;
  float low = length / kMetresPerMillimetre, high = low;
  for (int i = 0; i < 4; ++i, low = std::nextafter(low, 0.0f), high = std::nextafter(high, 2 * high)) {
    if (low * kMetresPerMillimetre == length) return low;
    if (high * kMetresPerMillimetre == length) return high;
  }
  return length / kMetresPerMillimetre;
}

const host::CameraDescription& camera_of(const RenderPassState& state,
                                         const std::map<Path, host::CameraDescription>& cameras) {
  if (state.freeCamera) return *state.freeCamera;
  if (state.camera.empty()) throw std::runtime_error("the pass has no camera; name one of the scene, or give one");
  const auto found = cameras.find(state.camera);
  if (found == cameras.end()) throw NotWritten(state.camera, "is no camera of the scene; name one that is");
  return found->second;
}

// The whole frame, and the part of it that the pass draws.
void set_window(const Framing& framing, json* settings) {
  const Rect2i& data = framing.dataWindow;
  if (data.empty()) throw std::runtime_error("the pass has no pixels; give its framing a data window");
  const Vec2f size = framing.displayMax - framing.displayMin;
  (*settings)["resolution"] = {data.width(), data.height()};
  if (!(size.x > 0 && size.y > 0)) return;
  const Vec2f corner = framing.displayMin;
  for (const float n : {size.x, size.y, corner.x, corner.y})
    if (n != std::trunc(n) || std::abs(n) > 0x1p24f)
      throw std::runtime_error("the display window ends within pixels, which is not written; give it whole numbers");
  const int x = static_cast<int>(corner.x), y = static_cast<int>(corner.y);
  const int width = static_cast<int>(size.x), height = static_cast<int>(size.y);
  (*settings)["resolution"] = {width, height};
  if (data != Rect2i{x, y, x + width, y + height})
    (*settings)["crop"] = {data.minX - x, data.minY - y, data.maxX - x, data.maxY - y};
}

}  // namespace

json written_motion(const Path& id, const Matrix4d& now, const TimeSamples<Matrix4d>& samples) {
  if (samples.values.size() < 2) return {};
  if (samples.times.size() != samples.values.size() || transform_at(samples, 0) != now)
    throw NotWritten(id, "moves, and stands elsewhere at time 0 than its samples say, which is not written");
  for (size_t i = 0; i < samples.times.size(); ++i)
    if (!std::isfinite(samples.times[i]) || (i > 0 && !(samples.times[i] > samples.times[i - 1])) ||
        !is_valid_affine(samples.values[i]))
      throw NotWritten(id,
                       "moves at times that do not rise or through a place that cannot be inverted; mend its samples");
  json motion = json::array();
  for (size_t i = 0; i < samples.times.size(); ++i)
    motion.push_back({{"time", samples.times[i]}, {"transform", to_json(samples.values[i])}});
  return motion;
}

json written_camera(const RenderPassState& state, const std::map<Path, host::CameraDescription>& cameras) {
  static const json properties = expanded_schema("camera")["properties"];
  const host::CameraDescription& camera = camera_of(state, cameras);
  if (!is_valid_affine(camera.transform))
    throw std::runtime_error("the camera stands at no place that can be inverted; mend its transform");
  const auto shutter = [&](const char* name) {
    const auto held = camera.parameters.find(name);
    return held == camera.parameters.end() ? 0.0 : held->second.number_or(0);
  };
  if (shutter("shutterClose") < shutter("shutterOpen"))
    throw std::runtime_error("the camera's shutter closes before it opens; give shutterClose a later time");
  json motion =
      written_motion(state.freeCamera ? "the camera" : state.camera, camera.transform, camera.transformSamples);
  json made = motion.empty() ? json{{"transform", to_json(camera.transform)}} : json{{"motion", std::move(motion)}};
  for (const auto& [name, property] : properties.items()) {
    const auto held = camera.parameters.find(name);
    if (held == camera.parameters.end() || held->second.empty()) continue;
    if (property.value("unitInDescription", "") == "mm")
      made[name] = millimetres_of(static_cast<float>(held->second.number_or(0)));
    else
      made[name] = to_json(held->second, property);
  }
  return made;
}

json written_settings(const RenderPassState& state, const std::map<Token, Value>& settings) {
  static const json properties = expanded_schema("render_settings")["properties"];
  json made = {{"windowPolicy", support::kWindowPolicyNames[static_cast<size_t>(state.windowPolicy)]},
               {"studio", "off"}};
  set_window(state.framing, &made);
  if (state.framing.pixelAspectRatio != 1) made["pixelAspectRatio"] = state.framing.pixelAspectRatio;
  for (const auto& [name, property] : properties.items())
    if (const auto held = settings.find(name); held != settings.end() && !held->second.empty())
      made[name] = to_json(held->second, property);
  return made;
}

}  // namespace alabaster::hd::description
