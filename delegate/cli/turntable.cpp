#include "delegate/cli/turntable.h"

#include <numbers>

namespace alabaster::cli {
Turntable::Turntable(SceneSession* session, bool lights) : session_(*session) {
  const auto cameras = session->scene.GetCameras();
  cameras_.assign(cameras.begin(), cameras.end());
  const auto all = session->scene.GetLights();
  if (lights) lights_.assign(all.begin(), all.end());
  const hd::description::WorldBox box = objects_box(session->scene);
  if (box.min.x <= box.max.x) middle_ = (box.min + box.max) / 2;  // else nothing is seen
  up_ = session->file.info.up == hd::Token("Z") ? hd::Vec3d(0, 0, 1) : hd::Vec3d(0, 1, 0);
}

void Turntable::turn(double degrees) {
  hd::Matrix4d turned;
  if (degrees != 0) {  // without rounding, as they stood
    hd::Matrix4d to_middle, rotation, back;
    to_middle.setTranslation(-middle_);
    rotation.setAxisAngle(up_, degrees * std::numbers::pi / 180);
    back.setTranslation(middle_);
    turned = to_middle * rotation * back;
  }
  for (auto [path, camera] : cameras_) {
    camera.transform *= turned;
    for (auto& sample : camera.transformSamples.values) sample *= turned;
    session_.scene.SetCamera(path, camera);
  }
  for (auto [path, light] : lights_) {
    light.transform *= turned;
    for (auto& sample : light.transformSamples.values) sample *= turned;
    session_.scene.SetLight(path, light);
  }
}

}  // namespace alabaster::cli
