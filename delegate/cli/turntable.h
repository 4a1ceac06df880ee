// A turn of the camera about the objects of a scene.
#pragma once

#include "delegate/cli/scene_session.h"

namespace alabaster::cli {

/// Turns all cameras of a loaded scene about the vertical line through the point that the description's camera looks
/// at, else through the middle of the objects. One thread.
class Turntable {
 public:
  /// `lights`: they turn with the cameras, as if the objects turned the other way.
  Turntable(SceneSession* session, bool lights);
  /// From where the cameras stood at first, seen from above against the clock. `step`: to the next frame; motion blur
  /// and AOV motion show that they turn.
  void turn(double degrees, double step);

 private:
  hd::Matrix4d turned(double degrees) const;
  template <class Prim>
  void turn_prim(double degrees, double step, Prim* prim) const;

  SceneSession& session_;
  std::vector<std::pair<hd::Path, hd::CameraDescription>> cameras_;
  std::vector<std::pair<hd::Path, hd::host::LightDescription>> lights_;
  hd::Vec3d middle_{0, 0, 0}, up_{0, 1, 0};
};

}  // namespace alabaster::cli
