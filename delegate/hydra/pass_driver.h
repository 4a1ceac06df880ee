// Brings a pass to its end for hosts that call Execute once in a frame and then poll. No type of OpenUSD.
#pragma once

#include <optional>

#include "delegate/api/render_delegate.h"

namespace alabaster::hydra {

/// A pass and what the host executed it with last. One thread at a time.
class PassDriver {
 public:
  explicit PassDriver(std::unique_ptr<hd::RenderPass> pass) : pass_(std::move(pass)) {}

  void Execute(const hd::RenderPassState& state);
  /// The first question after an Execute is answered at once, as hosts expect that execute before each question. A host
  /// that asks again without another Execute waits here for a moment, and the pass is executed for it.
  bool IsConverged();
  /// The buffer is about to be destroyed: a state that binds it is not executed again.
  void Forget(const hd::RenderBuffer* buffer);

 private:
  std::unique_ptr<hd::RenderPass> pass_;
  std::optional<hd::RenderPassState> state_;  // empty: nothing to execute
  bool was_asked_ = false;                    // since the host's last Execute
};

/// The pixels of a buffer as they are now, for a host that does not call Resolve. Unmap as usual.
const void* MapResolved(hd::RenderBuffer* buffer);

}  // namespace alabaster::hydra
