#include "delegate/hydra/pass_driver.h"

#include <algorithm>

namespace alabaster::hydra {
namespace {
constexpr double kPatience = 0.02;  // seconds: short beside a frame, long beside a host's empty loop
}

void PassDriver::Execute(const hd::RenderPassState& state) {
  state_ = state;
  was_asked_ = false;
  pass_->Execute(state);
}

bool PassDriver::IsConverged() {
  if (was_asked_ && state_ && !pass_->IsConverged()) {
    pass_->WaitForConvergence(kPatience);
    pass_->Execute(*state_);
  }
  was_asked_ = true;
  return pass_->IsConverged();
}

void PassDriver::Forget(const hd::RenderBuffer* buffer) {
  if (!state_) return;
  const auto& bindings = state_->aovBindings;
  if (std::any_of(bindings.begin(), bindings.end(), [&](const auto& b) { return b.renderBuffer == buffer; }))
    state_.reset();
}

const void* MapResolved(hd::RenderBuffer* buffer) {
  buffer->Resolve();
  return buffer->Map();
}

}  // namespace alabaster::hydra
