// An HdSceneDelegate behind the contract's SceneDelegate, for the Sync of one prim.
#pragma once

#include <pxr/imaging/hd/sceneDelegate.h>

#include <optional>

#include "delegate/hydra/translated_scene.h"

namespace alabaster::hydra {

/// Made for one Sync and destroyed after it: prims ask about themselves, and their instancers.
class HydraScene final : public TranslatedScene {
 public:
  /// `light_type`: of the prim, if it is a light.
  HydraScene(pxr::HdSceneDelegate* host, const pxr::SdfPath& id, bool domes_visible,
             const pxr::TfToken& light_type = {})
      : TranslatedScene(domes_visible), host_(host), id_(id), light_type_(light_type) {}

  hd::MeshTopology GetMeshTopology(const hd::Path& id) override;
  hd::SubdivTags GetSubdivTags(const hd::Path& id) override;
  hd::BasisCurvesTopology GetBasisCurvesTopology(const hd::Path& id) override;
  hd::DisplayStyle GetDisplayStyle(const hd::Path& id) override;
  hd::Matrix4d GetTransform(const hd::Path& id) override;
  bool GetVisible(const hd::Path& id) override;
  bool GetDoubleSided(const hd::Path& id) override;
  hd::CullStyle GetCullStyle(const hd::Path& id) override;
  hd::Token GetRenderTag(const hd::Path& id) override;
  std::vector<hd::Token> GetCategories(const hd::Path& id) override;
  hd::Path GetMaterialId(const hd::Path& id) override;
  hd::MaterialNetwork GetMaterialResource(const hd::Path& id) override;
  std::vector<hd::PrimvarDescriptor> GetPrimvarDescriptors(const hd::Path& id) override;
  hd::Value GetPrimvar(const hd::Path& id, const hd::Token& name, hd::Array<int32_t>* indices) override;
  hd::TimeSamples<hd::Matrix4d> SampleTransform(const hd::Path& id) override;
  hd::TimeSamples<hd::Value> SamplePrimvar(const hd::Path& id, const hd::Token& name) override;
  hd::TimeSamples<hd::Matrix4d> SampleInstancerTransform(const hd::Path& instancerId) override;
  hd::Path GetInstancerId(const hd::Path& primId) override;
  hd::Matrix4d GetInstancerTransform(const hd::Path& instancerId) override;
  hd::Array<int32_t> GetInstanceIndices(const hd::Path& instancerId, const hd::Path& prototypeId) override;
  std::vector<std::vector<hd::Token>> GetInstanceCategories(const hd::Path& instancerId) override;
  // Passes have their cameras by value, buffers are allocated by the host, and settings come through the delegate.
  hd::Value GetCameraParamValue(const hd::Path&, const hd::Token&) override { return {}; }
  hd::RenderBufferDescriptor GetRenderBufferDescriptor(const hd::Path&) override { return {}; }
  hd::RenderSettingsDescription GetRenderSettings(const hd::Path&) override { return {}; }

 protected:
  hd::Token GetHostLightType(const hd::Path& id) override;
  hd::Value GetHostLightParameter(const hd::Path& id, const hd::Token& name) override;

 private:
  pxr::SdfPath path(const hd::Path& id) const;
  /// The primvars of the prim that the host computes, such as the points of skinned meshes.
  const pxr::HdExtComputationPrimvarDescriptorVector& computed();
  const pxr::HdExtComputationPrimvarDescriptor* computed(const hd::Path& id, const hd::Token& name);

  pxr::HdSceneDelegate* host_;
  pxr::SdfPath id_;
  pxr::TfToken light_type_;
  std::vector<hd::PrimvarDescriptor> descriptors_;  // as asked for last
  std::optional<pxr::HdExtComputationPrimvarDescriptorVector> computed_;
};

}  // namespace alabaster::hydra
