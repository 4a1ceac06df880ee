// OpenUSD's render buffer over the contract's.
#pragma once

#include <pxr/imaging/hd/renderBuffer.h>

#include "delegate/api/prims.h"

namespace alabaster::hydra {

class HydraBuffer final : public pxr::HdRenderBuffer {
 public:
  HydraBuffer(const pxr::SdfPath& id, hd::RenderBuffer* buffer) : HdRenderBuffer(id), buffer_(buffer) {}
  hd::RenderBuffer* buffer() const { return buffer_; }

  void Finalize(pxr::HdRenderParam* param) override;
  bool Allocate(const pxr::GfVec3i& dimensions, pxr::HdFormat format, bool multiSampled) override;
  unsigned int GetWidth() const override { return static_cast<unsigned>(buffer_->GetWidth()); }
  unsigned int GetHeight() const override { return static_cast<unsigned>(buffer_->GetHeight()); }
  unsigned int GetDepth() const override { return 1; }
  pxr::HdFormat GetFormat() const override;
  bool IsMultiSampled() const override { return false; }
  /// Resolved, since not all hosts call Resolve (Blender does not).
  void* Map() override;
  void Unmap() override { buffer_->Unmap(); }
  bool IsMapped() const override { return buffer_->IsMapped(); }
  void Resolve() override { buffer_->Resolve(); }
  bool IsConverged() const override { return buffer_->IsConverged(); }

 protected:
  void _Deallocate() override {}

 private:
  hd::RenderBuffer* buffer_;
};

}  // namespace alabaster::hydra
