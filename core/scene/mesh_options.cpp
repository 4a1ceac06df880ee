#include "core/scene/mesh_options.h"

namespace alabaster {

std::span<const Parameter<MeshOptions>> mesh_parameters() {
  using O = MeshOptions;
  // The second line of a row is its unit and its description. clang-format would give each element a line.
  // clang-format off
  static constexpr Parameter<O> kTable[] = {
      {"visibleToCamera", &O::visible_to_camera, -kUnbounded, kUnbounded, {},
       "none", "False hides the mesh from the camera alone: it casts shadows, reflects and is reflected."},
      {"holdout", &O::holdout, -kUnbounded, kUnbounded, {},
       "none", "True if the mesh is a hole in the picture: colour and alpha are 0 where the camera sees it directly. "
       "Shadows, reflections and bounced light are as without it."},
      {"shadowCatcher", &O::shadow_catcher, -kUnbounded, kUnbounded, {},
       "none", "True if the camera sees of the mesh only the shadows that others cast on it: colour is 0, and alpha is "
       "the share of the light of lights that they keep away. Reflections and bounced light are as without it."},
      {"cryptoInstances", &O::crypto_instances, -kUnbounded, kUnbounded, {},
       "none", "True if each instance of the mesh has a Cryptomatte of its own, NAME.0, NAME.1 and on, by its number in "
       "AOV instanceId; else all have the mesh's."},
  };
  // clang-format on
  return kTable;
}

}  // namespace alabaster
