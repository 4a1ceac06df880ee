// The dirty bits of a host's prims.
#pragma once

#include <map>

#include "delegate/api/export.h"
#include "delegate/api/scene_types.h"

namespace alabaster::hd::host {

/// Dirty bits by prim. One thread at a time, never during Sync.
class ALABASTER_API ChangeTracker {
 public:
  void MarkDirty(const Path& id, DirtyBits bits);
  DirtyBits Get(const Path& id) const;
  void Set(const Path& id, DirtyBits bits);
  void Remove(const Path& id);
  /// The dirty prims alone, so that a Sync does not look at the others.
  const std::map<Path, DirtyBits>& GetDirty() const { return bits_; }
  /// Rises with every MarkDirty.
  uint64_t GetVersion() const { return version_; }

 private:
  std::map<Path, DirtyBits> bits_;  // none is clean
  uint64_t version_ = 0;
};

}  // namespace alabaster::hd::host
