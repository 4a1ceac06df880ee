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

void HydraRenderSettings::_Sync(pxr::HdSceneDelegate*, pxr::HdRenderParam*, const pxr::HdDirtyBits*) {
  if (!IsActive()) return delegate_->DropSceneSettings(GetId());
  delegate_->SetSceneSettings(GetId(), GetNamespacedSettings());
  std::vector<hd::Token> tags;
  for (const pxr::TfToken& purpose : GetIncludedPurposes())
    tags.push_back(purpose == "default" ? hd::Token("geometry") : ToToken(purpose));
  delegate_->param().products().set(GetRenderProducts(), tags);
}

}  // namespace alabaster::hydra
