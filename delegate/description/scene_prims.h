// The prims of a scene, whatever their kinds. Internal to this room.
#pragma once

#include <type_traits>
#include <utility>
#include <vector>

#include "delegate/host/scene_fields.h"

namespace alabaster::hd::description {

template <class Map>
std::vector<typename Map::key_type> keys_of(const Map& map) {
  std::vector<typename Map::key_type> keys;
  for (const auto& entry : map) keys.push_back(entry.first);
  return keys;
}

template <class T>
void put(host::RetainedSceneDelegate* scene, const Path& path, T prim) {
  host::for_each_kind([&](auto, auto set) {
    if constexpr (std::is_invocable_v<decltype(set), host::RetainedSceneDelegate*, const Path&, T>)
      (scene->*set)(path, std::move(prim));
  });
}

/// Calls visit(path, prim) for all prims but settings, kind by kind. It may put prims of the same paths and kinds.
template <class Visit>
void for_each_prim(const host::RetainedSceneDelegate& scene, const Visit& visit) {
  const auto each = [&](const auto& prims) {
    for (const auto& [path, prim] : prims) visit(path, prim);
  };
  each(scene.GetInstancers());
  each(scene.GetMeshes());
  each(scene.GetMaterials());
  each(scene.GetLights());
  each(scene.GetCameras());
}

}  // namespace alabaster::hd::description
