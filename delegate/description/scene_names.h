// The prims of a loaded scene for people: the names that authors of models gave, and where they are.
#pragma once

#include <limits>
#include <map>

#include "delegate/host/retained_scene_delegate.h"

namespace alabaster::hd::description {

/// The name that the author of a model gave: "skin" for "/gltf/bust/materials/2_skin", "head" for the mesh primitive
/// "/gltf/bust/nodes/3_head/0". Names in overrides and descriptions match it. `is_mesh`: the path is that of a mesh.
ALABASTER_API std::string AuthoredName(const Path& path, bool is_mesh);

/// A box in world space; without points `min` is above `max`.
struct WorldBox {
  Vec3d min = Vec3d(std::numeric_limits<double>::infinity()), max = -min;
};

/// The box of each mesh: of the points of its faces as they are modelled, before subdivision and displacement, at all
/// its instances. Hidden meshes have one, too.
ALABASTER_API std::map<Path, WorldBox> MeshBoxes(host::RetainedSceneDelegate& scene);

}  // namespace alabaster::hd::description
