#include "delegate/hydra/plugin/hydra_pass.h"

#include <pxr/imaging/hd/renderIndex.h>
#include <pxr/imaging/hd/renderPassState.h>

#include "delegate/hydra/plugin/hydra_buffer.h"
#include "delegate/hydra/plugin/hydra_prims.h"

namespace alabaster::hydra {
namespace {

// Data windows of OpenUSD include their last pixel. Some hosts give no framing, but the older viewport.
hd::Framing to_framing(const pxr::HdRenderPassState& state) {
  const pxr::CameraUtilFraming& theirs = state.GetFraming();
  hd::Framing ours;
  if (!theirs.IsValid()) {
    const pxr::GfVec4f& viewport = state.GetViewport();
    ours.displayMax = {viewport[2], viewport[3]};
    ours.dataWindow = {0, 0, static_cast<int>(viewport[2]), static_cast<int>(viewport[3])};
    return ours;
  }
  const auto &low = theirs.displayWindow.GetMin(), &high = theirs.displayWindow.GetMax();
  ours.displayMin = {low[0], low[1]};
  ours.displayMax = {high[0], high[1]};
  ours.dataWindow = {theirs.dataWindow.GetMinX(), theirs.dataWindow.GetMinY(), theirs.dataWindow.GetMaxX() + 1,
                     theirs.dataWindow.GetMaxY() + 1};
  ours.pixelAspectRatio = theirs.pixelAspectRatio;
  return ours;
}

static_assert(int(pxr::CameraUtilMatchVertically) == int(hd::WindowPolicy::matchVertically) &&
              int(pxr::CameraUtilMatchHorizontally) == int(hd::WindowPolicy::matchHorizontally) &&
              int(pxr::CameraUtilFit) == int(hd::WindowPolicy::fit) &&
              int(pxr::CameraUtilCrop) == int(hd::WindowPolicy::crop) &&
              int(pxr::CameraUtilDontConform) == int(hd::WindowPolicy::dontConform));

hd::Collection to_collection(const pxr::HdRprimCollection& theirs) {
  hd::Collection ours;
  for (const pxr::SdfPath& root : theirs.GetRootPaths())
    if (!root.IsAbsoluteRootPath()) ours.rootPaths.push_back(ToPath(root));
  for (const pxr::SdfPath& path : theirs.GetExcludePaths()) ours.excludePaths.push_back(ToPath(path));
  return ours;
}

}  // namespace

HydraPass::HydraPass(pxr::HdRenderIndex* index, const pxr::HdRprimCollection& collection,
                     std::unique_ptr<hd::RenderPass> pass, HydraParam* param)
    : HdRenderPass(index, collection), param_(param), driver_(std::move(pass)) {
  param_->add(&driver_);
}

HydraPass::~HydraPass() {
  param_->remove(&driver_);
}

std::vector<hd::AovBinding> HydraPass::bindings(const pxr::HdRenderPassState& state) const {
  std::vector<hd::AovBinding> ours;
  for (const pxr::HdRenderPassAovBinding& theirs : state.GetAovBindings()) {
    pxr::HdBprim* bound = theirs.renderBuffer;
    if (!bound) bound = GetRenderIndex()->GetBprim(pxr::HdPrimTypeTokens->renderBuffer, theirs.renderBufferId);
    if (const auto* buffer = dynamic_cast<HydraBuffer*>(bound))
      ours.push_back({ToToken(theirs.aovName), buffer->buffer(), ToValue(theirs.clearValue)});
  }
  return ours;
}

// A batch render of products leaves the host's own buffers as they are: nobody looks at them.
void HydraPass::_Execute(const pxr::HdRenderPassStateSharedPtr& state, const pxr::TfTokenVector& renderTags) {
  if (writes_products()) return param_->products().Execute(*GetRenderIndex());
  hd::RenderPassState ours;
  if (const auto* camera = dynamic_cast<const HydraCamera*>(state->GetCamera()))
    ours.freeCamera = camera->description();
  ours.renderTags = ToTokens(renderTags);
  ours.collection = to_collection(GetRprimCollection());
  ours.framing = to_framing(*state);
  ours.windowPolicy = static_cast<hd::WindowPolicy>(state->GetWindowPolicy());
  ours.aovBindings = bindings(*state);
  param_->write_scene(ours);
  driver_.Execute(ours);
}

bool HydraPass::writes_products() const {
  return param_->is_batch && !param_->products().empty();
}

bool HydraPass::IsConverged() const {
  if (writes_products()) return param_->products().IsConverged(*GetRenderIndex());
  return driver_.IsConverged();
}

}  // namespace alabaster::hydra
