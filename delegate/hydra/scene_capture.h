// The scene as the renderer was given it, as an archive that the program renders: to report a picture, or to compare.
#pragma once

#include <mutex>

#include "delegate/host/retained_scene_delegate.h"

namespace alabaster::hydra {

/// Takes each prim when it is synced for the first time, or again. Prims may be taken by several threads at once.
class SceneCapture {
 public:
  void TakeMesh(hd::SceneDelegate& scene, const hd::Path& id, const hd::Token& type = "mesh");
  void TakeInstancer(hd::SceneDelegate& scene, const hd::Path& id);
  void TakeMaterial(hd::SceneDelegate& scene, const hd::Path& id);
  void TakeLight(hd::SceneDelegate& scene, const hd::Path& id, const hd::Token& type);
  void Remove(const hd::Path& id);

  /// Writes what the pass draws, as archive::WritePass does. Returns "", or the reason.
  std::string Write(const std::string& file, const hd::RenderPassState& state,
                    const std::map<hd::Token, hd::Value>& settings) const;

 private:
  hd::host::InstancerDescription& instancer(const hd::Path& id);

  mutable std::mutex mutex_;
  hd::host::Prims prims_;
};

}  // namespace alabaster::hydra
