// The kinds of prims that a host's scene holds.
#pragma once

namespace alabaster::hd::support {

/// Calls call(get, set) with the functions of `Scene`, which is host::RetainedSceneDelegate, for each kind of prim.
template <class Scene, class Call>
constexpr void for_each_kind(const Call& call) {
  call(&Scene::GetMeshes, &Scene::SetMesh);
  call(&Scene::GetInstancers, &Scene::SetInstancer);
  call(&Scene::GetMaterials, &Scene::SetMaterial);
  call(&Scene::GetLights, &Scene::SetLight);
  call(&Scene::GetCameras, &Scene::SetCamera);
  call(&Scene::GetAllRenderSettings, &Scene::SetRenderSettings);
}

}  // namespace alabaster::hd::support
