// The prims of a scene, whatever their kinds. Internal to this room.
#pragma once

#include <type_traits>
#include <utility>
#include <vector>

#include "delegate/host/retained_scene_delegate.h"
#include "delegate/support/scene_kinds.h"

namespace alabaster::hd::description {

template <class Map>
std::vector<typename Map::key_type> keys_of(const Map& map) {
  std::vector<typename Map::key_type> keys;
  for (const auto& entry : map) keys.push_back(entry.first);
  return keys;
}

template <class Set, class T>
inline constexpr bool is_setter_of = std::is_invocable_v<Set, host::RetainedSceneDelegate*, const Path&, T>;

template <class T>
constexpr int count_setters() {
  int count = 0;
  support::for_each_kind<host::RetainedSceneDelegate>([&](auto, auto set) { count += is_setter_of<decltype(set), T>; });
  return count;
}

template <class T>
void put(host::RetainedSceneDelegate* scene, const Path& path, T prim) {
  static_assert(count_setters<T>() == 1, "one kind of prim is made of T");
  support::for_each_kind<host::RetainedSceneDelegate>([&](auto, auto set) {
    if constexpr (is_setter_of<decltype(set), T>) (scene->*set)(path, std::move(prim));
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
