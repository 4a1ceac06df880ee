// A render buffer in no scene and no index. Internal to this room.
#pragma once

#include "delegate/api/render_delegate.h"

namespace alabaster::hd::host {

/// Whatever happens to scene and index, it stays until this is destroyed.
class OwnBuffer {
 public:
  /// Without a buffer if the delegate makes none.
  OwnBuffer(RenderDelegate* delegate, const Path& id, const RenderBufferDescriptor& description) : delegate_(delegate) {
    Bprim* const made = delegate->CreateBprim("renderBuffer", id);
    buffer_ = dynamic_cast<RenderBuffer*>(made);
    if (buffer_)
      buffer_->Allocate(description);
    else if (made)
      delegate->DestroyBprim(made);
  }
  ~OwnBuffer() {
    if (!buffer_) return;
    buffer_->Finalize(delegate_->GetRenderParam());
    delegate_->DestroyBprim(buffer_);
  }
  OwnBuffer(const OwnBuffer&) = delete;
  OwnBuffer& operator=(const OwnBuffer&) = delete;
  RenderBuffer* get() const { return buffer_; }

 private:
  RenderDelegate* delegate_;
  RenderBuffer* buffer_ = nullptr;
};

}  // namespace alabaster::hd::host
