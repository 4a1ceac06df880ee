#include "delegate/prims/records.h"

#include "delegate/prims/parameters.h"

namespace alabaster::hd::sync {

bool same_light(const alabaster::LightDescription& a, const alabaster::LightDescription& b) {
  if (a.type != b.type || a.light_to_world != b.light_to_world || a.texture != b.texture) return false;
  for (const auto& parameter : light_parameters())
    if (!(get_parameter(parameter, a) == get_parameter(parameter, b))) return false;
  return true;
}

bool same_camera(const CameraParameters& a, const CameraParameters& b) {
  if (a.camera_to_world != b.camera_to_world || a.orthographic != b.orthographic || a.clip_near != b.clip_near ||
      a.clip_far != b.clip_far)
    return false;
  for (const auto& parameter : camera_parameters())
    if (!(get_parameter(parameter, a) == get_parameter(parameter, b))) return false;
  return true;
}

bool LightRecord::operator==(const LightRecord& o) const {
  return same_light(light, o.light);
}

bool same_scene_part(const Record& a, const Record& b) {
  if (a.index() != b.index()) return false;
  return std::visit(
      [&](const auto& x) {
        using T = std::decay_t<decltype(x)>;
        if constexpr (std::is_same_v<T, CameraRecord> || std::is_same_v<T, SettingsRecord>)
          return true;
        else
          return x == *std::get_if<T>(&b);
      },
      a);
}

}  // namespace alabaster::hd::sync
