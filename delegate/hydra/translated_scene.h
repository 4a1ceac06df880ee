// The pull side of the contract over a Hydra host, whose answers it puts into the contract's terms.
#pragma once

#include "delegate/api/scene_delegate.h"
#include "delegate/hydra/lights.h"
#include "delegate/hydra/materials.h"

namespace alabaster::hydra {

/// Geometry means the same in Hydra and here. Lights and materials are translated.
class TranslatedScene : public hd::SceneDelegate {
 public:
  /// `report`: the prim, then a diagnostic's code and text.
  using Report = std::function<void(const hd::Path& id, const char* code, const std::string& text)>;
  TranslatedScene(const LightRules& rules, Report report) : rules_(rules), report_(std::move(report)) {}

  hd::Value GetLightParamValue(const hd::Path& id, const hd::Token& name) final {
    return TranslateLightParameter(rules_, GetHostLightType(id), name,
                                   [&](const hd::Token& asked) { return GetHostLightParameter(id, asked); });
  }
  hd::MaterialNetwork GetMaterialResource(const hd::Path& id) final {
    const WarnMaterial warn = [&](const char* code, const std::string& text) { report_(id, code, text); };
    hd::MaterialNetwork network = TranslateMaterial(GetHostMaterial(id), warn);
    if (rules_.host == Host::blender) UseTheOnlyMap(&network, warn);
    return network;
  }

 protected:
  virtual hd::Token GetHostLightType(const hd::Path& id) = 0;
  virtual hd::Value GetHostLightParameter(const hd::Path& id, const hd::Token& name) = 0;
  virtual hd::MaterialNetwork GetHostMaterial(const hd::Path& id) = 0;

 private:
  LightRules rules_;
  Report report_;
};

}  // namespace alabaster::hydra
