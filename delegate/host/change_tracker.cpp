#include "delegate/host/change_tracker.h"

namespace alabaster::hd::host {

void ChangeTracker::MarkDirty(const Path& id, DirtyBits bits) {
  if (bits == dirty::kClean) return;
  bits_[id] |= bits;
  ++version_;
}

DirtyBits ChangeTracker::Get(const Path& id) const {
  const auto found = bits_.find(id);
  return found == bits_.end() ? dirty::kClean : found->second;
}

void ChangeTracker::Set(const Path& id, DirtyBits bits) {
  if (bits == dirty::kClean)
    bits_.erase(id);
  else
    bits_[id] = bits;
}

void ChangeTracker::Remove(const Path& id) {
  bits_.erase(id);
}

}  // namespace alabaster::hd::host
