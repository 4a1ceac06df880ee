// Where the prims of a loaded scene are.
#pragma once

#include <limits>
#include <map>

#include "delegate/host/retained_scene_delegate.h"

namespace alabaster::hd::description {

/// A box in world space; without points `min` is above `max`.
struct WorldBox {
  Vec3d min = Vec3d(std::numeric_limits<double>::infinity()), max = -min;
};

/// The box of each mesh: of the points of its faces as they are modelled, before subdivision and displacement, at all
/// its instances. Hidden meshes have one, too.
ALABASTER_API std::map<Path, WorldBox> MeshBoxes(host::RetainedSceneDelegate& scene);

}  // namespace alabaster::hd::description
