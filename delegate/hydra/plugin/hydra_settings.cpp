#include "delegate/hydra/plugin/hydra_settings.h"

#include <pxr/imaging/hd/retainedDataSource.h>
#include <pxr/imaging/hd/sceneIndexPluginRegistry.h>
#include <pxr/imaging/hdsi/renderSettingsFilteringSceneIndex.h>

namespace alabaster::hydra {

void RegisterSettingsSceneIndex() {
  using namespace pxr;
  static const bool once = [] {
    const auto arguments = HdRetainedContainerDataSource::New(
        HdsiRenderSettingsFilteringSceneIndexTokens->namespacePrefixes,
        HdRetainedTypedSampledDataSource<VtArray<TfToken>>::New({TfToken("alabaster")}));
    const auto append = [](const std::string&, const HdSceneIndexBaseRefPtr& scene,
                           const HdContainerDataSourceHandle& given) -> HdSceneIndexBaseRefPtr {
      return HdsiRenderSettingsFilteringSceneIndex::New(scene, given);
    };
    HdSceneIndexPluginRegistry::GetInstance().RegisterSceneIndexForRenderer(
        "Alabaster", append, arguments, 1, HdSceneIndexPluginRegistry::InsertionOrderAtStart);
    return true;
  }();
  (void)once;
}

// Products hold settings of their own, of which the engines of OpenUSD's hosts take none: they render at their own size.
void HydraRenderSettings::_Sync(pxr::HdSceneDelegate*, pxr::HdRenderParam*, const pxr::HdDirtyBits*) {
  if (IsActive())
    delegate_->SetSceneSettings(GetNamespacedSettings());
  else if (was_active_)
    delegate_->SetSceneSettings({});
  was_active_ = IsActive();
}

void HydraRenderSettings::Finalize(pxr::HdRenderParam* param) {
  if (was_active_) delegate_->SetSceneSettings({});
  was_active_ = false;
  HdRenderSettings::Finalize(param);
}

}  // namespace alabaster::hydra
