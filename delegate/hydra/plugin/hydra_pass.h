// OpenUSD's render pass over a pass driver.
#pragma once

#include <pxr/imaging/hd/renderPass.h>

#include "delegate/hydra/plugin/hydra_param.h"

namespace alabaster::hydra {

class HydraPass final : public pxr::HdRenderPass {
 public:
  /// `param` must outlive it.
  HydraPass(pxr::HdRenderIndex* index, const pxr::HdRprimCollection& collection, std::unique_ptr<hd::RenderPass> pass,
            HydraParam* param);
  ~HydraPass() override;
  bool IsConverged() const override;

 protected:
  void _Execute(const pxr::HdRenderPassStateSharedPtr& state, const pxr::TfTokenVector& renderTags) override;

 private:
  bool writes_products() const;
  std::vector<hd::AovBinding> bindings(const pxr::HdRenderPassState& state) const;

  HydraParam* param_;
  mutable PassDriver driver_;  // a question may bring the render on
};

}  // namespace alabaster::hydra
