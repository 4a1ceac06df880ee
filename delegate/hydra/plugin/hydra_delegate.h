// OpenUSD's render delegate over the contract's.
#pragma once

#include <pxr/imaging/hd/resourceRegistry.h>

#include "delegate/hydra/plugin/hydra_param.h"

namespace alabaster::hydra {

class HydraDelegate final : public pxr::HdRenderDelegate {
 public:
  /// Null after a warning if the renderer cannot start.
  static std::unique_ptr<HydraDelegate> Create(const pxr::HdRenderSettingsMap& settings);
  ~HydraDelegate() override;

  const pxr::TfTokenVector& GetSupportedRprimTypes() const override { return rprims_; }
  const pxr::TfTokenVector& GetSupportedSprimTypes() const override { return sprims_; }
  const pxr::TfTokenVector& GetSupportedBprimTypes() const override { return bprims_; }
  pxr::HdRenderParam* GetRenderParam() const override { return param_.get(); }
  pxr::HdResourceRegistrySharedPtr GetResourceRegistry() const override { return registry_; }

  void SetRenderSetting(const pxr::TfToken& key, const pxr::VtValue& value) override;
  /// The settings of the scene's active render settings prim, which come before the host's own: those of the renderer,
  /// and domeLightCameraVisibility. A scene may not name files to write.
  void SetSceneSettings(const pxr::SdfPath& prim, const pxr::VtDictionary& settings);
  /// A render settings prim is not active any more; its settings and products count no longer, if they did.
  void DropSceneSettings(const pxr::SdfPath& prim);
  HydraParam& param() const { return *param_; }
  pxr::HdRenderSettingDescriptorList GetRenderSettingDescriptors() const override;
  pxr::VtDictionary GetRenderStats() const override;
  bool IsPauseSupported() const override { return true; }
  bool IsPaused() const override { return delegate_->IsPaused(); }
  bool Pause() override { return delegate_->Pause(), true; }
  bool Resume() override { return delegate_->Resume(), true; }
  bool IsStopSupported() const override { return true; }
  bool IsStopped() const override { return delegate_->IsStopped(); }
  bool Stop(bool blocking) override;
  bool Restart() override { return delegate_->Restart(), true; }

  pxr::HdRenderPassSharedPtr CreateRenderPass(pxr::HdRenderIndex* index,
                                              const pxr::HdRprimCollection& collection) override;
  pxr::HdInstancer* CreateInstancer(pxr::HdSceneDelegate* scene, const pxr::SdfPath& id) override;
  void DestroyInstancer(pxr::HdInstancer* instancer) override;
  pxr::HdRprim* CreateRprim(const pxr::TfToken& type, const pxr::SdfPath& id) override;
  void DestroyRprim(pxr::HdRprim* prim) override;
  pxr::HdSprim* CreateSprim(const pxr::TfToken& type, const pxr::SdfPath& id) override;
  pxr::HdSprim* CreateFallbackSprim(const pxr::TfToken& type) override;
  void DestroySprim(pxr::HdSprim* prim) override;
  pxr::HdBprim* CreateBprim(const pxr::TfToken& type, const pxr::SdfPath& id) override;
  pxr::HdBprim* CreateFallbackBprim(const pxr::TfToken& type) override;
  void DestroyBprim(pxr::HdBprim* prim) override;
  void CommitResources(pxr::HdChangeTracker* tracker) override;

  pxr::TfToken GetMaterialBindingPurpose() const override;
  pxr::TfTokenVector GetMaterialRenderContexts() const override;
  pxr::TfTokenVector GetRenderSettingsNamespaces() const override;
  pxr::HdAovDescriptor GetDefaultAovDescriptor(const pxr::TfToken& aov) const override;

 private:
  HydraDelegate(hd::RenderDelegate* delegate, const hd::DiagnosticSink& sink);
  void apply(const Setting& setting);
  void apply_scene(std::map<hd::Token, hd::Value> now);
  bool is_for_scenes(const hd::Token& key) const;
  hd::Value host_setting(const hd::Token& key) const;

  hd::RenderDelegate* delegate_;  // destroyed after all that the host has made of it
  std::unique_ptr<HydraParam> param_;
  std::vector<hd::RenderSettingDescriptor> settings_;
  std::map<hd::Token, hd::Value> host_settings_, scene_settings_;
  pxr::SdfPath settings_prim_;  // whose settings the scene's are
  pxr::TfTokenVector rprims_, sprims_, bprims_;
  pxr::HdResourceRegistrySharedPtr registry_;
};

}  // namespace alabaster::hydra
