#include "delegate/hydra/plugin/hydra_prims.h"

#include <pxr/imaging/hd/changeTracker.h>
#include <pxr/imaging/hd/renderIndex.h>

#include <type_traits>
#include <utility>

#include "delegate/hydra/plugin/hydra_param.h"

namespace alabaster::hydra {
namespace {

using Tracker = pxr::HdChangeTracker;

constexpr BitPair kGeometryBits[] = {
    {Tracker::DirtyPrimID, hd::dirty::kPrimId},         {Tracker::DirtyDisplayStyle, hd::dirty::kDisplayStyle},
    {Tracker::DirtyPoints, hd::dirty::kPoints},         {Tracker::DirtyPrimvar, hd::dirty::kPrimvar},
    {Tracker::DirtyMaterialId, hd::dirty::kMaterialId}, {Tracker::DirtyTopology, hd::dirty::kTopology},
    {Tracker::DirtyTransform, hd::dirty::kTransform},   {Tracker::DirtyVisibility, hd::dirty::kVisibility},
    {Tracker::DirtyNormals, hd::dirty::kNormals},       {Tracker::DirtyDoubleSided, hd::dirty::kDoubleSided},
    {Tracker::DirtyCullStyle, hd::dirty::kCullStyle},   {Tracker::DirtySubdivTags, hd::dirty::kSubdivTags},
    {Tracker::DirtyInstancer, hd::dirty::kInstancer},   {Tracker::DirtyInstanceIndex, hd::dirty::kInstanceIndex},
    {Tracker::DirtyRenderTag, hd::dirty::kRenderTag},   {Tracker::DirtyCategories, hd::dirty::kCategories},
    {Tracker::DirtyWidths, hd::dirty::kPrimvar}};
// Hydra has no bit for a light's visibility: hosts send DirtyParams.
constexpr BitPair kLightBits[] = {{pxr::HdLight::DirtyTransform, hd::dirty::kTransform},
                                  {pxr::HdLight::DirtyParams, hd::dirty::kParams | hd::dirty::kVisibility},
                                  {pxr::HdLight::DirtyShadowParams, hd::dirty::kParams},
                                  {pxr::HdLight::DirtyCollection, hd::dirty::kParams},
                                  {pxr::HdLight::DirtyResource, hd::dirty::kResource}};
constexpr BitPair kMaterialBits[] = {{pxr::HdMaterial::DirtyParams, hd::dirty::kParams},
                                     {pxr::HdMaterial::DirtyResource, hd::dirty::kResource}};

/// Syncs a prim of the contract. True if nothing is left dirty.
template <class Prim>
bool sync(Prim* prim, HydraScene* scene, HydraParam& param, hd::DirtyBits bits) {
  if (!prim || bits == hd::dirty::kClean) return true;
  prim->Sync(scene, param.delegate().GetRenderParam(), &bits);
  if (bits != hd::dirty::kClean) return false;  // tried again with each pass, which is no change
  param.products().SceneChanged();
  return true;
}

}  // namespace

template <class Theirs, class Ours>
void HydraPrim<Theirs, Ours>::Finalize(pxr::HdRenderParam* param) {
  HydraParam& shared = ParamOf(param);
  shared.products().SceneChanged();
  if (!prim_) return;
  if (shared.capture()) shared.capture()->Remove(prim_->GetId());
  prim_->Finalize(shared.delegate().GetRenderParam());
}

template class HydraPrim<pxr::HdMesh, hd::Rprim>;
template class HydraPrim<pxr::HdBasisCurves, hd::Rprim>;
template class HydraPrim<pxr::HdPoints, hd::Rprim>;
template class HydraPrim<pxr::HdInstancer, hd::Instancer>;
template class HydraPrim<pxr::HdMaterial, hd::Sprim>;
template class HydraPrim<pxr::HdLight, hd::Sprim>;

template <class Theirs>
pxr::HdDirtyBits HydraRprim<Theirs>::GetInitialDirtyBitsMask() const {
  pxr::HdDirtyBits bits = Tracker::InitRepr;
  for (const BitPair& pair : kGeometryBits) bits |= pair.host;
  return bits;
}

template <class Theirs>
void HydraRprim<Theirs>::_InitRepr(const pxr::TfToken& repr, pxr::HdDirtyBits*) {
  for (const auto& [name, held] : this->_reprs)
    if (name == repr) return;
  this->_reprs.emplace_back(repr, pxr::HdReprSharedPtr());
}

template <class Theirs>
void HydraRprim<Theirs>::Sync(pxr::HdSceneDelegate* scene, pxr::HdRenderParam* param, pxr::HdDirtyBits* bits,
                              const pxr::TfToken&) {
  this->_UpdateVisibility(scene, bits);
  this->_UpdateInstancer(scene, bits);
  pxr::HdInstancer::_SyncInstancerAndParents(scene->GetRenderIndex(), this->GetInstancerId());
  HydraParam& shared = ParamOf(param);
  hd::Rprim* const ours = this->prim();
  const pxr::SdfPath& id = this->GetId();
  if (ours) ours->SetPrimId(this->GetPrimId());
  HydraScene pulled = shared.scene(scene, id);
  constexpr bool kIsCurves = std::is_same_v<Theirs, pxr::HdBasisCurves>,
                 kIsPoints = std::is_same_v<Theirs, pxr::HdPoints>;
  const char* const type = hd::kRprimTypes[kIsCurves ? 1 : kIsPoints ? 2 : 0];
  if (SceneCapture* const capture = shared.capture()) capture->TakeMesh(pulled, ToPath(id), type);
  if (sync(ours, &pulled, shared, TranslateBits(*bits, kGeometryBits))) *bits &= ~Tracker::AllSceneDirtyBits;
}

template class HydraRprim<pxr::HdMesh>;
template class HydraRprim<pxr::HdBasisCurves>;
template class HydraRprim<pxr::HdPoints>;

void HydraInstancer::Sync(pxr::HdSceneDelegate* scene, pxr::HdRenderParam* param, pxr::HdDirtyBits* bits) {
  _UpdateInstancer(scene, bits);
  HydraParam& shared = ParamOf(param);
  HydraScene pulled = shared.scene(scene, GetId());
  if (SceneCapture* const capture = shared.capture()) capture->TakeInstancer(pulled, ToPath(GetId()));
  sync(prim(), &pulled, shared, TranslateBits(*bits, kGeometryBits));
}

void HydraMaterial::Sync(pxr::HdSceneDelegate* scene, pxr::HdRenderParam* param, pxr::HdDirtyBits* bits) {
  HydraParam& shared = ParamOf(param);
  HydraScene pulled = shared.scene(scene, GetId());
  if (SceneCapture* const capture = shared.capture()) capture->TakeMaterial(pulled, ToPath(GetId()));
  if (sync(prim(), &pulled, shared, TranslateBits(*bits, kMaterialBits))) *bits = Clean;
}

void HydraLight::Sync(pxr::HdSceneDelegate* scene, pxr::HdRenderParam* param, pxr::HdDirtyBits* bits) {
  HydraParam& shared = ParamOf(param);
  HydraScene pulled = shared.scene(scene, GetId(), type_);
  shared.add_light(GetId(), &scene->GetRenderIndex());
  if (SceneCapture* const capture = shared.capture()) capture->TakeLight(pulled, ToPath(GetId()), ToToken(type_));
  if (sync(prim(), &pulled, shared, TranslateBits(*bits, kLightBits))) *bits = Clean;
}

void HydraLight::Finalize(pxr::HdRenderParam* param) {
  ParamOf(param).remove_light(GetId());
  HydraPrim::Finalize(param);
}

void HydraCamera::warn_of_unread(const HydraParam& param) {
  if (GetLensDistortionType().IsEmpty() || GetLensDistortionType() == "standard") return;
  if (!std::exchange(warned_of_distortion_, true))
    param.warn(GetId(), "camera.unread", "lens distortion is not read; the lens is ideal");
}

void HydraCamera::Sync(pxr::HdSceneDelegate* scene, pxr::HdRenderParam* param, pxr::HdDirtyBits* bits) {
  const bool moved = *bits & DirtyTransform;
  HdCamera::Sync(scene, param, bits);
  ParamOf(param).products().SceneChanged();
  description_.transform = ToMatrix(GetTransform());
  const hd::Path id = ToPath(GetId());
  if (moved) description_.transformSamples = ParamOf(param).scene(scene, GetId()).SampleTransform(id);
  auto& parameters = description_.parameters;
  parameters = {{"projection", hd::Token(GetProjection() == Orthographic ? "orthographic" : "perspective")},
                {"focalLength", GetFocalLength()},
                {"horizontalAperture", GetHorizontalAperture()},
                {"verticalAperture", GetVerticalAperture()},
                {"horizontalApertureOffset", GetHorizontalApertureOffset()},
                {"verticalApertureOffset", GetVerticalApertureOffset()},
                {"fStop", GetFStop()},
                {"focusDistance", GetFocusDistance()},
                {"exposure", GetExposure()},
                {"shutterOpen", GetShutterOpen()},
                {"shutterClose", GetShutterClose()}};
  if (!GetClippingRange().IsEmpty())
    parameters["clippingRange"] = hd::Vec2f(GetClippingRange().GetMin(), GetClippingRange().GetMax());
  std::vector<hd::Vec4f> planes;
  for (const pxr::GfVec4d& p : GetClipPlanes())
    planes.emplace_back(static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2]),
                        static_cast<float>(p[3]));
  if (!planes.empty()) parameters["clipPlanes"] = hd::Array<hd::Vec4f>(std::move(planes));
  warn_of_unread(ParamOf(param));
}

}  // namespace alabaster::hydra
