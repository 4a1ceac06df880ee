// OpenUSD's render settings prim, which UsdRenderSettings becomes.
#pragma once

#include <pxr/imaging/hd/renderSettings.h>

#include "delegate/hydra/plugin/hydra_delegate.h"

namespace alabaster::hydra {

class HydraRenderSettings final : public pxr::HdRenderSettings {
 public:
  /// `delegate` must outlive it.
  HydraRenderSettings(const pxr::SdfPath& id, HydraDelegate* delegate) : HdRenderSettings(id), delegate_(delegate) {}

 protected:
  void _Sync(pxr::HdSceneDelegate* scene, pxr::HdRenderParam* param, const pxr::HdDirtyBits* bits) override;

 private:
  HydraDelegate* delegate_;
};

/// Lets OpenUSD tell these prims whether they are active, in each render index made for the renderer from then on.
void RegisterSettingsSceneIndex();

}  // namespace alabaster::hydra
