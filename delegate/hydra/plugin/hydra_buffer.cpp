#include "delegate/hydra/plugin/hydra_buffer.h"

#include "delegate/hydra/plugin/hydra_param.h"

namespace alabaster::hydra {

void HydraBuffer::Finalize(pxr::HdRenderParam* param) {
  ParamOf(param).forget(buffer_);
  HdRenderBuffer::Finalize(param);
  buffer_->Finalize(ParamOf(param).delegate().GetRenderParam());
}

bool HydraBuffer::Allocate(const pxr::GfVec3i& dimensions, pxr::HdFormat format, bool) {
  return buffer_->Allocate({.dimensions = {dimensions[0], dimensions[1], dimensions[2]}, .format = ToFormat(format)});
}

pxr::HdFormat HydraBuffer::GetFormat() const {
  return FromFormat(buffer_->GetFormat());
}

void* HydraBuffer::Map() {
  return const_cast<void*>(MapResolved(buffer_));
}

}  // namespace alabaster::hydra
