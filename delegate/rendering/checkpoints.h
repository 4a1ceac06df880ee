// The commands of checkpoints, and the one from which the next render continues. Commands: host thread; the rest is
// asked by whichever thread starts a render.
#pragma once

#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "delegate/api/render_delegate.h"
#include "delegate/rendering/checkpoint_file.h"

namespace alabaster::hd::rendering {

class DelegateState;
struct BuiltScene;

class Checkpoints {
 public:
  using Memory = std::shared_ptr<MemoryBudget>;

  // Commands. A film that `memory` has no room for is not read.
  /// Writes the state of the frame that Execute drew last, with a note for who reads it.
  CommandResult write(const DelegateState& delegate, const std::string& file, const std::string& note) const;
  /// The next render that starts continues from this file; an empty name takes that back.
  CommandResult resume(const std::string& file, const Memory& memory);
  /// Passes show the sum of these files, which are parts of one frame, instead of the scene; no file takes that back.
  CommandResult show(const Array<std::string>& files, const Memory& memory);
  /// Reads {firstSample, samples, complete, note} of a file, and with `measure` what its pixels tell of themselves.
  static CommandResult describe(const std::string& file, bool measure, const Memory& memory);

  /// Why a render of the scene cannot go on from the file; empty if it can, or none was named. Null: of no scene.
  std::string fault(const DelegateState& delegate, const BuiltScene* scene, const RenderRequest& request) const;
  /// The next render continues from a file, which is compared with the scene as it will be.
  bool is_pending() const { return pending() != nullptr; }
  bool is_shown() const { return shown_; }
  /// The names of what AOVs number in the files that are shown; null: none are.
  std::shared_ptr<const prims::IdNames> shown_names() const;
  /// The state from which the next render continues. Null: nothing was named.
  std::shared_ptr<RenderState> take();

 private:
  struct Pending {
    std::string file;
    CheckpointHeader header;
    std::shared_ptr<RenderState> state;
    MemoryReservation held;  // of the header
  };
  using Digests = std::map<std::string, std::string>;
  std::shared_ptr<const Pending> pending() const;
  void set_pending(std::shared_ptr<const Pending> pending, bool shown);
  CheckpointHeader header_of(const RenderRequest& request, const DelegateState& delegate,
                             const BuiltScene& scene) const;
  std::shared_ptr<const Digests> digests_of(const BuiltScene& scene) const;

  mutable std::mutex mutex_;                           // guards pending_
  std::shared_ptr<const Pending> pending_;             // null: none
  std::shared_ptr<const prims::IdNames> shown_names_;  // likewise guarded
  mutable std::mutex digests_mutex_;                   // held while they are made
  mutable uint64_t digested_ = 0;                      // the number of the snapshot that digests_ are of
  mutable std::shared_ptr<const Digests> digests_;
  std::atomic<bool> shown_{false};
};

}  // namespace alabaster::hd::rendering
