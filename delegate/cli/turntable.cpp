#include "delegate/cli/turntable.h"

#include <cmath>
#include <numbers>

namespace alabaster::cli {
Turntable::Turntable(SceneSession* session, bool lights) : session_(*session) {
  const auto cameras = session->scene.GetCameras();
  cameras_.assign(cameras.begin(), cameras.end());
  const auto all = session->scene.GetLights();
  if (lights) lights_.assign(all.begin(), all.end());
  const hd::description::WorldBox box = objects_box(session->scene);
  if (box.min.x <= box.max.x) middle_ = (box.min + box.max) / 2;  // else nothing is seen
  middle_ = session->file.look_at.value_or(middle_);
  up_ = session->file.info.up == hd::Token("Z") ? hd::Vec3d(0, 0, 1) : hd::Vec3d(0, 1, 0);
}

hd::Matrix4d Turntable::turned(double degrees) const {
  if (degrees == 0) return {};  // without rounding, as they stood
  hd::Matrix4d to_middle, rotation, back;
  to_middle.setTranslation(-middle_);
  rotation.setAxisAngle(up_, degrees * std::numbers::pi / 180);
  back.setTranslation(middle_);
  return to_middle * rotation * back;
}

// Between samples it would leave the circle: they lie as close as poses of the renderer.
template <class Prim>
void Turntable::turn_prim(double degrees, double step, Prim* prim) const {
  auto& samples = prim->transformSamples;
  if (samples.values.empty()) {
    constexpr double kLargestTurn = 3;
    const auto count = static_cast<int>(std::ceil(std::abs(step) / kLargestTurn));
    for (int i = -count; i <= count; ++i)
      samples.times.push_back(double(i) / count), samples.values.push_back(prim->transform);
  }
  for (size_t i = 0; i < samples.values.size(); ++i) samples.values[i] *= turned(degrees + step * samples.times[i]);
  prim->transform *= turned(degrees);
}

void Turntable::turn(double degrees, double step) {
  for (auto [path, camera] : cameras_) {
    turn_prim(degrees, step, &camera);
    session_.scene.SetCamera(path, camera);
  }
  for (auto [path, light] : lights_) {
    turn_prim(degrees, step, &light);
    session_.scene.SetLight(path, light);
  }
}

}  // namespace alabaster::cli
