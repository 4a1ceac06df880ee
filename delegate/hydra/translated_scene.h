// The pull side of the contract over a Hydra host, whose answers it puts into the contract's terms.
#pragma once

#include "delegate/api/scene_delegate.h"

namespace alabaster::hydra {

/// Geometry means the same in Hydra and here, and materials are read by the renderer. Lights are translated.
class TranslatedScene : public hd::SceneDelegate {
 public:
  /// `domes_visible`: to the camera, where a dome does not say (Hydra's setting domeLightCameraVisibility).
  explicit TranslatedScene(bool domes_visible) : domes_visible_(domes_visible) {}

  /// The host's value of the name, or of that with "inputs:" before it, as the schema of UsdLux has it.
  hd::Value GetLightParamValue(const hd::Path& id, const hd::Token& name) final {
    hd::Value found = GetHostLightParameter(id, name);
    if (found.empty()) found = GetHostLightParameter(id, "inputs:" + name.str());
    const bool is_unsaid = found.empty() && name == hd::Token("visibleToCamera");
    return is_unsaid && GetHostLightType(id) == hd::Token("domeLight") ? domes_visible_ : found;
  }

 protected:
  virtual hd::Token GetHostLightType(const hd::Path& id) = 0;
  virtual hd::Value GetHostLightParameter(const hd::Path& id, const hd::Token& name) = 0;

 private:
  bool domes_visible_;
};

}  // namespace alabaster::hydra
